# Installs the build, then configures, builds and runs the project beside this file against what was installed.
# usage: cmake -DSOURCE_DIR=... -DBUILD_DIR=... -DWORK_DIR=... -DCONFIG=... -DCOMPILER=... -DFLAGS=... -P run.cmake
cmake_minimum_required(VERSION 3.25)

function(step name)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK_DIR} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${name} failed (${code}):\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
step("install" ${CMAKE_COMMAND} --install ${BUILD_DIR} --config "${CONFIG}" --prefix ${WORK_DIR}/prefix)
step("configure" ${CMAKE_COMMAND} -G Ninja -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=${CONFIG})
step("build" ${CMAKE_COMMAND} --build ${WORK_DIR}/build)
file(COPY ${SOURCE_DIR}/assets/teapot.bpt DESTINATION ${WORK_DIR})
step("run" ${WORK_DIR}/build/ten_lines)
file(STRINGS ${WORK_DIR}/teapot.obj faces REGEX "^f ")
list(LENGTH faces count)
if(count LESS 1000)
  message(FATAL_ERROR "teapot.obj has only ${count} triangles")
endif()

# Its exit code says whether the chord error was kept.
step("run within" ${WORK_DIR}/build/within)

# What the README shows is what was built here.
file(READ ${SOURCE_DIR}/README.md readme)
foreach(name IN ITEMS ten_lines within)
  file(READ ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp program)
  string(FIND "${readme}" "${program}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "README.md does not show tests/install/${name}.cpp as it is")
  endif()
endforeach()
