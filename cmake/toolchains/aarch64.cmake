# ARM, 64 bits: has fused multiply-add, char is unsigned.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(ticktrue_triplet aarch64-linux-gnu)
set(ticktrue_qemu qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
