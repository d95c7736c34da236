# ticktrue_add_trace_test(NAME name TRACE file [PLUGIN target-or-library] [COMMAND program argument...] [ARGUMENTS ...])
# Registers a trace as a CTest test: green where it still runs bit for bit the same.
#   TRACE      the trace, relative to the current source directory
#   PLUGIN     a target of this project, or a library: the simulation, if it is not the tool's own
#   COMMAND    a program that owns its loop: it is run with --verify and the trace behind its arguments
#   ARGUMENTS  more words for `ticktrue verify`
# A trace that cannot be judged (exit code 5: other version, schema or simulation) counts as failed, not as skipped.
function(ticktrue_add_trace_test)
  cmake_parse_arguments(PARSE_ARGV 0 test "" "NAME;TRACE;PLUGIN" "COMMAND;ARGUMENTS")
  if(NOT test_NAME OR NOT test_TRACE)
    message(FATAL_ERROR "ticktrue_add_trace_test: found no NAME or no TRACE, expected both")
  endif()
  if(test_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "ticktrue_add_trace_test: found ${test_UNPARSED_ARGUMENTS}, expected NAME, TRACE, PLUGIN, COMMAND, ARGUMENTS")
  endif()
  if(test_PLUGIN AND test_COMMAND)
    message(FATAL_ERROR "ticktrue_add_trace_test: found PLUGIN and COMMAND, expected at most one of them")
  endif()
  get_filename_component(trace "${test_TRACE}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
  if(test_COMMAND)
    add_test(NAME "${test_NAME}" COMMAND ${test_COMMAND} --verify "${trace}" ${test_ARGUMENTS})
    return()
  endif()
  set(plugin)
  if(TARGET "${test_PLUGIN}")
    set(plugin --plugin "$<TARGET_FILE:${test_PLUGIN}>")
  elseif(test_PLUGIN)
    get_filename_component(library "${test_PLUGIN}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    set(plugin --plugin "${library}")
  endif()
  add_test(NAME "${test_NAME}" COMMAND ticktrue::tool verify "${trace}" ${plugin} ${test_ARGUMENTS})
endfunction()
