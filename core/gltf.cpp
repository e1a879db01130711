#include "core/gltf.h"
