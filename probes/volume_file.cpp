#include "probes/volume_file.h"
