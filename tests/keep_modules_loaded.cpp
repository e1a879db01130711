// With AddressSanitizer only: drivers that GLFW and GLX have loaded stay loaded, so that what they keep until the end of
// the process is found in their own variables and not taken for a leak.
extern "C" int dlclose(void* /*module*/) noexcept {
    return 0;
}
