# Compiles for ZIG_TARGET, such as aarch64-linux-gnu.2.28, by ZIG, the program of the wheel `ziglang`, on any machine.
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ZIG ZIG_TARGET)
string(REGEX MATCH "^([^-]+)-([^-.]+)" target ${ZIG_TARGET})
set(CMAKE_SYSTEM_PROCESSOR ${CMAKE_MATCH_1})
set(system_linux Linux)
set(system_macos Darwin)
set(system_windows Windows)
set(CMAKE_SYSTEM_NAME ${system_${CMAKE_MATCH_2}})

set(CMAKE_CXX_COMPILER ${ZIG} c++)
set(CMAKE_CXX_COMPILER_TARGET ${ZIG_TARGET})
# CMake's trials link nothing, or zig would compile its C++ library a second time, for debugging.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# As commands, since CMAKE_AR has no place for zig's word `ar`.
set(CMAKE_CXX_ARCHIVE_CREATE "\"${ZIG}\" ar qcD <TARGET> <LINK_FLAGS> <OBJECTS>")
set(CMAKE_CXX_ARCHIVE_APPEND "\"${ZIG}\" ar qD <TARGET> <LINK_FLAGS> <OBJECTS>")
set(CMAKE_CXX_ARCHIVE_FINISH "\"${ZIG}\" ranlib <TARGET>")
# Headers of nanobind use stdio.h without including it, which only libstdc++ forgives.
set(CMAKE_CXX_FLAGS_INIT "-include stdio.h")
# Of Apple's tools and libraries zig needs none, and CMake only believes that it does.
set(CMAKE_OSX_SYSROOT "")
set(CMAKE_INSTALL_NAME_TOOL ${ZIG})
set(CMAKE_SKIP_RPATH ON)
