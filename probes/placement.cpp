#include "probes/placement.h"
