#include "probes/volume.h"
