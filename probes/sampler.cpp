#include "probes/sampler.h"
