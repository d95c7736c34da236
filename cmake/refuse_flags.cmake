# Stops the configuration if a compiler or linker flag would change results. Also runs as a script: cmake -P. Flags are
# found by name, since not every compiler has a macro for each flag. Linker flags are checked, too: g++ -shared
# -ffast-math makes the whole process flush denormals to zero.
cmake_minimum_required(VERSION 3.25)
set(ticktrue_banned_flags
  -ffast-math -Ofast -ffp-contract=fast -funsafe-math-optimizations -fassociative-math -freciprocal-math -ffinite-math-only
  -fno-signed-zeros -fapprox-func -ffp-model=fast -mrelaxed-simd -mdaz-ftz)
string(TOUPPER "${CMAKE_BUILD_TYPE}" ticktrue_build_type)
foreach(variable CMAKE_CXX_FLAGS CMAKE_EXE_LINKER_FLAGS CMAKE_SHARED_LINKER_FLAGS)
  foreach(suffix "" "_${ticktrue_build_type}")
    separate_arguments(flags UNIX_COMMAND "${${variable}${suffix}}")
    foreach(flag IN LISTS flags)
      if(flag IN_LIST ticktrue_banned_flags)
        message(FATAL_ERROR "${variable}${suffix}: ${flag} changes results: found in \"${flags}\"\n"
          "  remove it: docs/determinism.md, \"Compiler flags\"")
      endif()
    endforeach()
  endforeach()
endforeach()
