# The flags that make bits portable. Every target links ticktrue_determinism; docs/determinism.md has the reasons.
include(${CMAKE_CURRENT_LIST_DIR}/refuse_flags.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/float_flags.cmake)

add_library(ticktrue_determinism INTERFACE)
target_compile_features(ticktrue_determinism INTERFACE cxx_std_20)
target_include_directories(ticktrue_determinism INTERFACE ${PROJECT_SOURCE_DIR})
ticktrue_float_flags(ticktrue_own_float_flags ${CMAKE_CXX_COMPILER_ID})
if(NOT ticktrue_own_float_flags)
  message(FATAL_ERROR "CMAKE_CXX_COMPILER: no flags are known that keep floats the same: found ${CMAKE_CXX_COMPILER_ID}, "
    "expected GNU or Clang\n  docs/determinism.md, \"Compiler flags\"")
endif()
target_compile_options(ticktrue_determinism INTERFACE ${ticktrue_own_float_flags})

add_library(ticktrue_warnings INTERFACE)
target_compile_options(ticktrue_warnings INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # GCC 12 invents overlaps in "a" + std::string (GCC bug 105651)
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 15)
  target_compile_options(ticktrue_warnings INTERFACE -Wno-deprecated-declarations  # std::stable_sort of libstdc++ 12
    -Wno-shadow)  # copies of structured bindings for lambdas, which clang 14 needs
endif()
if(CMAKE_SIZEOF_VOID_P EQUAL 4)
  # Sizes and counts of files are 64 bits wide and checked against base/limits.h before they become a size_t.
  target_compile_options(ticktrue_warnings INTERFACE -Wno-conversion)
endif()
