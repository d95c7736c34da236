# RISC-V, 64 bits: has fused multiply-add, one bit pattern of NaN.
set(CMAKE_SYSTEM_PROCESSOR riscv64)
set(ticktrue_triplet riscv64-linux-gnu)
set(ticktrue_qemu qemu-riscv64)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
