function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
string(REPLACE "," ";" components ${COMPONENTS})
foreach(component IN LISTS components)
  run(${CMAKE_COMMAND} --install ${BUILD} --component ${component} --prefix ${WORK}/first)
endforeach()
# Packages are unpacked anywhere: no path of the first place may be in them.
file(RENAME ${WORK}/first ${WORK}/moved)
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/build -G ${GENERATOR} -D CMAKE_CXX_COMPILER=${COMPILER}
    -D CMAKE_CXX_FLAGS=${FLAGS} -D CMAKE_PREFIX_PATH=${WORK}/moved)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer ${WORK}/sky.probes.exr)
