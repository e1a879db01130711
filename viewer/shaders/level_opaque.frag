#version 330 core
#include "level.glsl"
