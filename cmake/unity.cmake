# TICKTRUE_UNITY: sources are compiled together, all of a target at once, or CMAKE_UNITY_BUILD_BATCH_SIZE of them.
# Headers are then read once instead of ninety times, which is most of the time of a first build.
if(TICKTRUE_UNITY)
  target_compile_options(ticktrue_warnings INTERFACE -Wno-shadow)  # local names of one file beside those of another
  set(apart tool/import/import_rube.cpp)  # its local names are those of another file
  if(WIN32)
    list(APPEND apart tool/output/progress.cpp)  # `near` and `far` are macros of windows.h
  endif()
  foreach(source ${apart})
    set_source_files_properties(${PROJECT_SOURCE_DIR}/${source} DIRECTORY tool PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endif()
