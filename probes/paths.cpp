#include "probes/paths.h"
