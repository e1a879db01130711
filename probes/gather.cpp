#include "probes/gather.h"
