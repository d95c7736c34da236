# The flags that make bits portable. Every target links ticktrue_determinism; docs/determinism.md has the reasons.
include(${CMAKE_CURRENT_LIST_DIR}/refuse_flags.cmake)

add_library(ticktrue_determinism INTERFACE)
target_compile_features(ticktrue_determinism INTERFACE cxx_std_20)
target_include_directories(ticktrue_determinism INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(ticktrue_determinism INTERFACE
  -ffp-contract=off   # a fused multiply-add rounds once where two operations round twice
  -fno-math-errno     # sqrt as the instruction, not the library's function
)
add_library(ticktrue_warnings INTERFACE)
target_compile_options(ticktrue_warnings INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Werror
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # GCC 12 invents overlaps in "a" + std::string (GCC bug 105651)
