# The flags that make bits portable. Every target links ticktrue_determinism; docs/determinism.md has the reasons.
include(${CMAKE_CURRENT_LIST_DIR}/refuse_flags.cmake)

add_library(ticktrue_determinism INTERFACE)
target_compile_features(ticktrue_determinism INTERFACE cxx_std_20)
target_include_directories(ticktrue_determinism INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(ticktrue_determinism INTERFACE
  -ffp-contract=off   # a fused multiply-add rounds once where two operations round twice
  -fno-math-errno     # sqrt as the instruction, not the library's function
)
# GCC (12 at least) turns a * b -+ c * d into vfmaddsub whatever -ffp-contract says, when it vectorizes straight-line code
# for a target that has it (found by the golden traces at -O3 -march=x86-64-v3).
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(ticktrue_determinism INTERFACE -fno-tree-slp-vectorize)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|i[3-6]86")
  target_compile_options(ticktrue_determinism INTERFACE -mno-fma)
endif()

add_library(ticktrue_warnings INTERFACE)
target_compile_options(ticktrue_warnings INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Werror
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # GCC 12 invents overlaps in "a" + std::string (GCC bug 105651)
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 15)
  target_compile_options(ticktrue_warnings INTERFACE -Wno-deprecated-declarations  # std::stable_sort of libstdc++ 12
    -Wno-shadow)  # copies of structured bindings for lambdas, which clang 14 needs
endif()
if(CMAKE_SIZEOF_VOID_P EQUAL 4)
  # Sizes and counts of files are 64 bits wide and checked against base/limits.h before they become a size_t.
  target_compile_options(ticktrue_warnings INTERFACE -Wno-conversion)
endif()
