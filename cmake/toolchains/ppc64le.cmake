# POWER, little-endian: has fused multiply-add.
set(CMAKE_SYSTEM_PROCESSOR ppc64le)
set(ticktrue_triplet powerpc64le-linux-gnu)
set(ticktrue_qemu qemu-ppc64le)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
