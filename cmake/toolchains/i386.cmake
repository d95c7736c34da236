# x86, 32 bits: floats in SSE registers, since x87 computes in 80 bits. Runs without an emulator, on Debian's cross libraries.
set(CMAKE_SYSTEM_PROCESSOR i686)
set(ticktrue_triplet i686-linux-gnu)
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
set(CMAKE_CXX_FLAGS_INIT "-msse2 -mfpmath=sse")
set(CMAKE_CROSSCOMPILING_EMULATOR
  "env;LD_LIBRARY_PATH=/usr/i686-linux-gnu/lib;/usr/i686-linux-gnu/lib/ld-linux.so.2")
