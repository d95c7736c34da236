# Tests that a build with changed results is refused, by the compiler or at configuration, with the reason.
set(ticktrue_probe ${CMAKE_CURRENT_BINARY_DIR}/refusal_probe.cpp)
file(CONFIGURE OUTPUT ${ticktrue_probe} CONTENT "#include \"base/bytes.h\"\nint main() { return 0; }\n")

# ticktrue_add_refusal_test NAME MESSAGE FLAG...: compiling the probe with the flags fails with the message.
function(ticktrue_add_refusal_test name message)
  add_test(NAME refusal_${name}
    COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only -I${PROJECT_SOURCE_DIR} ${ARGN} ${ticktrue_probe})
  set_tests_properties(refusal_${name} PROPERTIES PASS_REGULAR_EXPRESSION "${message}")
endfunction()

# The control: without such a flag, the same file compiles.
add_test(NAME refusal_none
  COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only -I${PROJECT_SOURCE_DIR} ${ticktrue_probe})
ticktrue_add_refusal_test(fast_math "fast-math changes results" -ffast-math)
ticktrue_add_refusal_test(ofast "fast-math changes results" -Ofast)
ticktrue_add_refusal_test(finite_math "fast-math changes results" -ffinite-math-only)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  ticktrue_add_refusal_test(unsafe_math "fast-math changes results" -funsafe-math-optimizations)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|i.86")
    ticktrue_add_refusal_test(x87 "floats must be evaluated in their own precision" -mfpmath=387)
  endif()
endif()

# Flags without a macro are refused at configuration.
foreach(variable CMAKE_CXX_FLAGS CMAKE_EXE_LINKER_FLAGS)
  add_test(NAME refusal_configure_${variable}
    COMMAND ${CMAKE_COMMAND} -D${variable}=-fassociative-math -DCMAKE_BUILD_TYPE=Release
      -P ${PROJECT_SOURCE_DIR}/cmake/refuse_flags.cmake)
  set_tests_properties(refusal_configure_${variable} PROPERTIES PASS_REGULAR_EXPRESSION "changes results")
endforeach()
