# IBM Z: big-endian, has fused multiply-add.
set(CMAKE_SYSTEM_PROCESSOR s390x)
set(ticktrue_triplet s390x-linux-gnu)
set(ticktrue_qemu qemu-s390x)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
