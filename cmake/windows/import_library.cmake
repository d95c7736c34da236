# Writes the name of the library into the linker's .def, and makes the .lib that the linkers of Microsoft and LLVM read.
# SPDX-License-Identifier: MIT
# cmake -D DEF=F.def -D DLL=NAME.dll -D LIB=F.lib [-D LLD_LINK=PROGRAM] -P import_library.cmake
file(READ ${DEF} exports)
if(NOT exports MATCHES "^LIBRARY")
  file(WRITE ${DEF} "LIBRARY ${DLL}\n${exports}")
endif()
if(LLD_LINK)
  execute_process(COMMAND ${LLD_LINK} /lib /machine:x64 /nologo /def:${DEF} /out:${LIB} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${LIB}: ${LLD_LINK} made no import library: ${failed}")
  endif()
else()
  message(STATUS "no lld-link: ${LIB} is left out; ${DEF} is there")
endif()
