# find_package(nanoweft): the target nanoweft::nanoweft, with all that it is linked with.
include(${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/nanoweftTargets.cmake)
