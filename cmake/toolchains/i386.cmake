# x86, 32 bits: floats in SSE registers, since x87 computes in 80 bits. Runs on Debian's cross libraries: without an
# emulator where the kernel runs 32-bit programs, else under qemu.
#
# Both ways name the folder of the libraries. Otherwise the loader takes the machine's own 32-bit C library (/lib32 of
# libc6-i386) from /etc/ld.so.cache. Loader and library of two builds disagree on shared structures: pthread_create then
# loops forever.
set(CMAKE_SYSTEM_PROCESSOR i686)
set(ticktrue_triplet i686-linux-gnu)
set(ticktrue_libraries LD_LIBRARY_PATH=/usr/i686-linux-gnu/lib)
set(ticktrue_loader /usr/i686-linux-gnu/lib/ld-linux.so.2)
execute_process(COMMAND ${ticktrue_loader} --version RESULT_VARIABLE ticktrue_loader_code OUTPUT_QUIET ERROR_QUIET)
if(NOT ticktrue_loader_code EQUAL 0)
  set(ticktrue_qemu qemu-i386 -E ${ticktrue_libraries})
endif()
include(${CMAKE_CURRENT_LIST_DIR}/linux.cmake)
set(CMAKE_CXX_FLAGS_INIT "-msse2 -mfpmath=sse")
if(NOT ticktrue_qemu)
  set(CMAKE_CROSSCOMPILING_EMULATOR "env;${ticktrue_libraries};${ticktrue_loader}")
endif()
