#include "core/sh.h"
