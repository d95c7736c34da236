# The compiler flags that keep the bits of a float, in one list for ticktrue's own build and for ticktrue::determinism.
# docs/determinism.md, "Compiler flags", gives the reason of each flag; tests/examples/float_flags.sh measures the
# flags.

# Sets `out` to whether the compilers of this project build for x86. The test asks the compiler, not
# CMAKE_SYSTEM_PROCESSOR: a cross compiler without a toolchain file leaves that variable at the host's value.
function(ticktrue_builds_for_x86 out)
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  set(CMAKE_REQUIRED_QUIET ON)
  set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # linking does not matter here
  set(CMAKE_REQUIRED_FLAGS -Werror)  # clang for other targets accepts the flag with a warning
  if("CXX" IN_LIST languages)
    include(CheckCXXCompilerFlag)
    check_cxx_compiler_flag(-mno-avx512f TICKTRUE_CXX_TAKES_X86_FLAGS)
    set(${out} "${TICKTRUE_CXX_TAKES_X86_FLAGS}" PARENT_SCOPE)
  elseif("C" IN_LIST languages)
    include(CheckCCompilerFlag)
    check_c_compiler_flag(-mno-avx512f TICKTRUE_C_TAKES_X86_FLAGS)
    set(${out} "${TICKTRUE_C_TAKES_X86_FLAGS}" PARENT_SCOPE)
  else()
    set(${out} OFF PARENT_SCOPE)
  endif()
endfunction()

# Sets `out` to the flags for a compiler with this CMAKE_<LANG>_COMPILER_ID; empty for compilers that were not measured.
function(ticktrue_float_flags out id)
  set(flags "")
  if(id MATCHES "^(GNU|Clang|AppleClang)$")
    set(flags -ffp-contract=off -fno-math-errno)
    if(id STREQUAL "GNU")
      list(APPEND flags -fno-tree-slp-vectorize)
    endif()
    # GCC's vectorizer emits vfmaddsub for any value of -ffp-contract. AVX-512F has this instruction even with FMA off.
    ticktrue_builds_for_x86(for_x86)
    if(for_x86)
      list(APPEND flags -mno-fma -mno-fma4 -mno-avx512f)
    endif()
  endif()
  set(${out} "${flags}" PARENT_SCOPE)
endfunction()
