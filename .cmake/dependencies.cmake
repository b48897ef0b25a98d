# All from the system; nothing is downloaded.
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
file(GLOB openvdb_modules /usr/lib/*/cmake/OpenVDB)
list(APPEND CMAKE_MODULE_PATH ${openvdb_modules})

find_package(Threads REQUIRED)
find_package(Imath REQUIRED)
find_package(TBB REQUIRED)
find_package(OpenVDB REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(embree 3 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(hwy REQUIRED)
# NanoVDB's headers call these two directly.
find_package(ZLIB REQUIRED)
find_library(OBSCURA_BLOSC blosc REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(netcdf REQUIRED IMPORTED_TARGET netcdf)
# Its CMake package asks for targets that Debian does not install.
pkg_check_modules(assimp REQUIRED IMPORTED_TARGET assimp)

# Some packages name include folders that are not installed (opencv4 behind OpenImageIO).
function(obscura_drop_missing_includes target)
  get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
  if(folders)
    set(present "")
    foreach(folder IN LISTS folders)
      if(folder MATCHES "^\\$<" OR EXISTS "${folder}")
        list(APPEND present "${folder}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES "${present}"
      INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${present}")
  endif()
endfunction()
foreach(target OpenImageIO::OpenImageIO OpenImageIO::OpenImageIO_Util)
  if(TARGET ${target})
    obscura_drop_missing_includes(${target})
  endif()
endforeach()

add_library(obscura_dependencies INTERFACE)
target_link_libraries(obscura_dependencies INTERFACE
  OpenVDB::openvdb OpenImageIO::OpenImageIO embree hwy::hwy fmt::fmt
  nlohmann_json::nlohmann_json CLI11::CLI11 PkgConfig::netcdf PkgConfig::assimp ZLIB::ZLIB ${OBSCURA_BLOSC} Threads::Threads)
