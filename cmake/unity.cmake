# TICKTRUE_UNITY: sources are compiled together, so that their headers are read once instead of ninety times, which is most
# of the time of a first build: all of a target at once, or CMAKE_UNITY_BUILD_BATCH_SIZE of them.
if(TICKTRUE_UNITY)
  target_compile_options(ticktrue_warnings INTERFACE -Wno-shadow)  # local names of one file beside those of another
  # Their local names collide with those of another file. tests/platforms/one.sh builds file by file where this list
  # misses one.
  # Of these the C interface's archive is made, without what knows the engine.
  file(GLOB shared_sources RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/verifier/report*.cpp
    ${PROJECT_SOURCE_DIR}/verifier/locate*.cpp)
  foreach(source ${shared_sources} verifier/compare_tick.cpp verifier/schema_difference.cpp
      verifier/exit_codes.cpp
      engine/clock/tick_clock.cpp engine/forces/forces.cpp engine/geometry/hull.cpp
      engine/integrators/integrator.cpp engine/scene_json.cpp engine/solvers/solver.cpp engine/stages/inputs.cpp
      engine/stages/islands.cpp replay/trace_chunks.cpp verifier/import_rube.cpp)
    string(REGEX MATCH "^[a-z]+" folder ${source})
    set_source_files_properties(${PROJECT_SOURCE_DIR}/${source} DIRECTORY ${folder}
      PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endif()
