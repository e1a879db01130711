#include "core/tracer.h"
