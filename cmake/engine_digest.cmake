# The digest of the inputs of a build's verdicts: sources after preprocessing, flags and compiler of each unit.
# Comments, line numbers, names of folders and the commit have no effect.
#
# ticktrue_engine_digest(OUT NAME TARGET...): OUT becomes a source file that defines the lines NAME, one for each unit
# of the targets (tool/corpus/engine_digest.h).
# TARGET:FILE means one unit of a target. When a unit's object was rebuilt and time or size of a file that it reads has
# changed, the unit is preprocessed again. If a file is newer than the object, somebody edited it during the build: this
# build gets a digest of its own. Without Ninja, a POSIX shell's tools or a native build there is no digest, and
# `ticktrue corpus` reports this.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(ticktrue_engine_digest out lines)
    set(folder ${CMAKE_BINARY_DIR}/engine_digest)
    find_program(TICKTRUE_SED sed)
    find_program(TICKTRUE_SHA256SUM sha256sum)
    mark_as_advanced(TICKTRUE_SED TICKTRUE_SHA256SUM)
    set(parts)
    if(CMAKE_GENERATOR STREQUAL Ninja AND TICKTRUE_SED AND TICKTRUE_SHA256SUM AND NOT CMAKE_CROSSCOMPILING
        AND NOT CMAKE_TOOLCHAIN_FILE)
      foreach(unit ${ARGN})
        string(MAKE_C_IDENTIFIER "${unit}" name)
        set(part ${folder}/${name}.txt)
        string(REGEX REPLACE ":.*" "" target "${unit}")
        string(REPLACE ":" ".dir/" objects "${unit}")
        if(objects STREQUAL target)
          string(APPEND objects ".dir/")
        endif()
        add_custom_command(OUTPUT ${part}
          COMMAND ${CMAKE_COMMAND} -D UNIT=${objects} -D PART=${part} -D BUILD=${CMAKE_BINARY_DIR} -D CXX=${CMAKE_CXX_COMPILER}
            -D SED=${TICKTRUE_SED} -D SHA256SUM=${TICKTRUE_SHA256SUM} -P ${PROJECT_SOURCE_DIR}/cmake/engine_digest.cmake
          DEPENDS ${PROJECT_SOURCE_DIR}/cmake/engine_digest.cmake $<TARGET_OBJECTS:${target}>
          COMMENT "Digest of ${unit}"
          VERBATIM)
        list(APPEND parts ${part})
      endforeach()
    endif()
    add_custom_command(OUTPUT ${out}
      COMMAND ${CMAKE_COMMAND} -D "PARTS=${parts}" -D OUT=${out} -D LINES=${lines} -P ${PROJECT_SOURCE_DIR}/cmake/engine_digest.cmake
      DEPENDS ${PROJECT_SOURCE_DIR}/cmake/engine_digest.cmake ${parts}
      COMMENT "Digest: ${lines}"
      VERBATIM)
  endfunction()
  return()
endif()

cmake_policy(VERSION 3.25)

# Writes a file only if its text differs, so that nothing is compiled again for the same digest.
function(write_changed file text)
  set(old "")
  if(EXISTS ${file})
    file(READ ${file} old)
  endif()
  if(NOT "${old}" STREQUAL "${text}" OR NOT EXISTS ${file})
    file(WRITE ${file} "${text}")
  endif()
endfunction()

if(DEFINED OUT)
  set(lines "")
  foreach(part ${PARTS})
    file(STRINGS ${part} found)
    list(APPEND lines ${found})
  endforeach()
  list(SORT lines)
  set(literals "")
  foreach(line ${lines})
    string(APPEND literals "    \"${line}\\n\"\n")
  endforeach()
  write_changed(${OUT} "// Made by cmake/engine_digest.cmake: the units of this build, each with the hashes of its text and of its flags.
#include \"tool/corpus/engine_digest.h\"

namespace ticktrue::tool {
extern const char* const ${LINES};
const char* const ${LINES} =
    \"\"\n${literals}    ;
}  // namespace ticktrue::tool
")
  return()
endif()

# One hash of the times and sizes of the files that a unit reads, and whether one of these files is newer than its
# object.
function(look_at_files fingerprint is_edited depfile object)
  set(${fingerprint} "" PARENT_SCOPE)
  set(${is_edited} FALSE PARENT_SCOPE)
  if(NOT EXISTS ${depfile})
    return()
  endif()
  file(READ ${depfile} text)
  string(REGEX REPLACE "^[^:]*:" "" text "${text}")
  string(REGEX REPLACE "[\\\\\n]" " " text "${text}")
  separate_arguments(files UNIX_COMMAND "${text}")
  set(seen "")
  foreach(file ${files})
    if(NOT EXISTS "${file}")
      return()
    endif()
    file(TIMESTAMP "${file}" time "%s.%f" UTC)
    file(SIZE "${file}" size)
    string(APPEND seen "${file} ${time} ${size}\n")
    if("${file}" IS_NEWER_THAN "${object}")
      set(${is_edited} TRUE PARENT_SCOPE)
    endif()
  endforeach()
  string(SHA256 hash "${seen}")
  set(${fingerprint} ${hash} PARENT_SCOPE)
endfunction()

# One line of compile_commands.json is the command of a unit, with the escapes of JSON.
string(REPLACE "." "\\." pattern "${UNIT}")
file(STRINGS ${BUILD}/compile_commands.json commands REGEX "\"command\":.* -o [^ ]*${pattern}[^ ]*\\.o ")
if(NOT commands)
  message(FATAL_ERROR "engine digest: ${UNIT}: found no such unit in compile_commands.json, expected one")
endif()
execute_process(COMMAND ${CXX} --version OUTPUT_VARIABLE compiler)
execute_process(COMMAND ${CXX} -dumpmachine OUTPUT_VARIABLE machine)
string(REGEX MATCH "^[^\n]*" compiler "${compiler}")
string(STRIP "${machine}" machine)
string(TIMESTAMP now "%s.%f" UTC)
set(lines)
foreach(command ${commands})
  string(REGEX REPLACE "^ *\"command\": \"(.*)\",?$" "\\1" command "${command}")
  string(REPLACE "\\\"" "\"" command "${command}")
  string(REPLACE "\\\\" "\\" command "${command}")
  separate_arguments(words UNIX_COMMAND "${command}")
  # The launcher of the compiler (ccache), folders, names of files and the commit do not change the results of a
  # program.
  set(call)
  set(flags)
  set(is_call FALSE)
  set(skip 0)
  foreach(word ${words})
    if(word STREQUAL CXX OR word STREQUAL "${CXX}")
      set(is_call TRUE)
    endif()
    if(skip GREATER 0)
      set(skip 0)
      set(object "${BUILD}/${word}")
      continue()
    endif()
    if(NOT is_call OR word STREQUAL "-c" OR word MATCHES "^-DTICKTRUE_COMMIT=")
      continue()
    endif()
    if(word STREQUAL "-o")
      set(skip 1)
      continue()
    endif()
    list(APPEND call "${word}")
    if(NOT word MATCHES "^(-I|/)" AND NOT word STREQUAL "-isystem")
      list(APPEND flags "${word}")
    endif()
  endforeach()
  list(POP_BACK words source)
  if(NOT call OR NOT EXISTS "${source}")
    message(FATAL_ERROR "engine digest: ${UNIT}: cannot read the command: ${command}")
  endif()
  if("${flags}" MATCHES "-fprofile-(instr-)?use")
    list(APPEND flags "${now}")  # the contents of profiles are unknown: each build gets its own digest
  endif()
  string(SHA256 flags_hash "${flags} ${compiler} ${machine}")
  string(MD5 name "${source}")
  set(stamp ${PART}.${name})
  look_at_files(files is_edited ${stamp}.d "${object}")
  set(known "")
  if(EXISTS ${stamp})
    file(READ ${stamp} known)
  endif()
  set(line "")
  if(files AND known MATCHES "^${files} ([0-9a-f]+ ${flags_hash})$")
    set(line "${CMAKE_MATCH_1}")
  else()
    execute_process(
      COMMAND ${call} -w -E -P -D__LINE__=0 -D__FILE__="" -MD -MF ${stamp}.d -MT part
      COMMAND ${SED} -e "s/[[:space:]]*$//" -e "/^$/d"
      COMMAND ${SHA256SUM}
      WORKING_DIRECTORY ${BUILD} OUTPUT_VARIABLE sum ERROR_VARIABLE errors RESULTS_VARIABLE codes)
    if(NOT "${codes}" STREQUAL "0;0;0")
      message(FATAL_ERROR "engine digest: ${source}: cannot be preprocessed (${codes}):\n${errors}")
    endif()
    string(REGEX MATCH "^[0-9a-f]+" sum "${sum}")
    set(line "${sum} ${flags_hash}")
    look_at_files(files is_edited ${stamp}.d "${object}")
    file(WRITE ${stamp} "${files} ${line}")
  endif()
  if(is_edited OR NOT files)
    string(APPEND line " edited while the build ran, ${now}")
  endif()
  list(APPEND lines "${line}")
endforeach()
list(SORT lines)
list(JOIN lines "\n" text)
write_changed(${PART} "${text}\n")
