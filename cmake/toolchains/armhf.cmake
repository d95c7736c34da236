# ARM, 32 bits, hard float: no NEON, which would flush denormals to zero (docs/determinism.md).
set(CMAKE_SYSTEM_PROCESSOR arm)
set(ticktrue_triplet arm-linux-gnueabihf)
set(ticktrue_qemu qemu-arm)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
set(CMAKE_CXX_FLAGS_INIT "-mfpu=vfpv3-d16 -Wno-psabi")
