# What the library and the tool need; scripts/setup installs it. The tests look for their own, and
# conddp-config.cmake.in repeats what a program needs that links the library.
list(APPEND CMAKE_MODULE_PATH ${PROJECT_SOURCE_DIR}/cmake/modules)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(nlohmann_json 3.10 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(pugixml REQUIRED)
find_package(ConddpHdf5 REQUIRED)
find_package(ConddpIpopt REQUIRED)
find_package(ConddpMd REQUIRED)
find_package(ConddpUrdfdom REQUIRED)
find_package(ConddpYaml REQUIRED)
