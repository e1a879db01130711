#version 330 core
#define SEE_THROUGH
#include "level.glsl"
