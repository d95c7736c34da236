# TICKTRUE_UNITY: sources are compiled together, all of a target at once, or CMAKE_UNITY_BUILD_BATCH_SIZE of them.
# Headers are then read once instead of ninety times, which is most of the time of a first build.
if(TICKTRUE_UNITY)
  target_compile_options(ticktrue_warnings INTERFACE -Wno-shadow)  # local names of one file beside those of another
  set(apart)
  if(CMAKE_UNITY_BUILD_BATCH_SIZE EQUAL 0)
    set(apart tool/study/stress/stress_contacts.cpp)
  endif()
  if(WIN32)
    list(APPEND apart tool/output/progress.cpp)  # `near` and `far` are macros of windows.h
  endif()
  # Local names of these files collide with those of another file. tests/platforms/one.sh builds file by file if this
  # list lacks a file.
  foreach(source ${apart}
      verifier/report/exit_codes.cpp
      verifier/report/fact_differences.cpp
      verifier/report/likely_causes.cpp
      verifier/report/machine.cpp
      verifier/report/report.cpp
      verifier/report/report_ci.cpp
      verifier/report/report_json.cpp
      verifier/report/report_text.cpp
      verifier/report/report_transfer.cpp
      verifier/locate/compare_tick.cpp
      verifier/locate/locate.cpp
      verifier/locate/locate_cells.cpp
      verifier/locate/schema_difference.cpp
      engine/clock/tick_clock.cpp
      engine/integrators/forces.cpp
      engine/integrators/integrator.cpp
      engine/islands/islands.cpp
      engine/scene/hull.cpp
      engine/scene/scene_json.cpp
      engine/solvers/solver.cpp
      engine/stages/inputs.cpp
      replay/trace_ticks.cpp
      tool/import/import_rube.cpp)
    string(REGEX MATCH "^[a-z]+" folder ${source})
    set_source_files_properties(${PROJECT_SOURCE_DIR}/${source} DIRECTORY ${folder}
      PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endif()
