# The common part of the Linux cross toolchains: Debian's cross compiler for ticktrue_triplet, and qemu's user mode
# emulator of ticktrue_qemu. Libraries of the build machine are never found.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_CXX_COMPILER ${ticktrue_triplet}-g++)
if(ticktrue_qemu)
  set(CMAKE_CROSSCOMPILING_EMULATOR "${ticktrue_qemu};-L;/usr/${ticktrue_triplet}")
endif()
set(CMAKE_FIND_ROOT_PATH /usr/${ticktrue_triplet})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
