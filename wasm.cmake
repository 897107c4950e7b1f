# The core as WebAssembly modules, for the viewer's page: viewer/core.wasm in simd128 and viewer/core.relaxed.wasm in
# relaxed-simd, both again without shapes other than meshes, viewer/core.mesh*.wasm, which have lights as viewer/core.mesh.light*.wasm,
# and with the networks alone, viewer/complete*.wasm. In viewer/core*.threads.relaxed.wasm, threads share memory. Compiled by the clang of the wheel
# `ziglang`; without that wheel, the package is built without them.
#
# The first build on a machine compiles zig's C++ library, which takes about a minute; zig keeps it, and all objects, in its
# own cache. Exceptions need three sources of that library which zig leaves out.
execute_process(
  COMMAND ${Python_EXECUTABLE} -c "import ziglang; print(ziglang.__path__[0])"
  OUTPUT_VARIABLE zig OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT zig)
  message(WARNING "ziglang is not installed: bobrossnet is built without its WebAssembly modules, which the viewer needs")
  return()
endif()

set(wasm_compiler ${Python_EXECUTABLE} -m ziglang c++ -target wasm32-wasi)
set(wasm_flags -O3 -std=c++20 -fvisibility=hidden -ffp-contract=off -msimd128 -Wno-psabi -Wno-bitwise-conditional-parentheses
  -I ${PROJECT_SOURCE_DIR}/core -DBOB_ISA=baseline
  # All modules are made of the same objects: those that share memory need atomics, also where zig's library has no threads itself.
  -matomics -mbulk-memory -U_LIBCPP_HAS_THREADS -D_LIBCPP_HAS_THREADS=1 -D_LIBCPP_HAS_THREAD_API_PTHREAD=1)
# Browsers keep the order of instructions: loads that clang gathers at the top of a loop would need more registers than there are.
set(completion_kernel_flags -mllvm -pre-RA-sched=linearize)
# All else runs once for each shape, or leaves the work to kernels: it is to be small, since pages fetch it.
set(fast_sources
  core/base/bvh.cpp
  core/base/color.cpp
  core/files/binary.cpp
  core/files/inflate.cpp
  core/files/welding.cpp
  core/completion/guided.cpp
  core/completion/guided_fit.cpp
  core/completion/guided_samples.cpp
  core/completion/guided_surfaces.cpp
  core/light/edges.cpp
  core/light/light_history.cpp
  core/light/lighting.cpp
  core/formula/graph.cpp
  core/formula/mesh_distance.cpp
  core/formula/tape.cpp
  core/nurbs/trim.cpp
  core/shapes/implicit/cells_build.cpp
  core/shapes/implicit/implicit.cpp
  core/shapes/mesh/triangles.cpp
  core/shapes/tube/tube.cpp
  core/sampling/adaptive.cpp
  core/reprojection/history.cpp
  core/sampling/refresh.cpp
  core/sampling/squares.cpp
  core/tracing/scene.cpp)
# Zig itself takes -Oz for -Os.
set(small_flags -Os -Xclang -Oz)
set(exception_flags -fwasm-exceptions -mexception-handling -mllvm -wasm-use-legacy-eh=false)
set(libcxxabi_flags -O2 -std=c++23 -w -D_LIBCXXABI_BUILDING_LIBRARY -D_LIBCPP_BUILDING_LIBRARY
  -DLIBCXX_BUILDING_LIBCXXABI -D_LIBCXXABI_HAS_NO_THREADS -matomics -mbulk-memory -I ${zig}/lib/libcxxabi/include -I ${zig}/lib/libcxx/src)

# Stores the path of the precompiled standard headers for these flags in `parsed`: parsing them takes half of a compilation.
function(precompile_standard_headers parsed)
  string(MD5 key "${ARGN}")
  set(precompiled ${CMAKE_BINARY_DIR}/wasm/headers.${key}.pch)
  set(${parsed} ${precompiled} PARENT_SCOPE)
  get_property(known GLOBAL PROPERTY precompiled_for_wasm)
  if(precompiled IN_LIST known)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY precompiled_for_wasm ${precompiled})
  add_custom_command(
    OUTPUT ${precompiled}
    COMMAND ${wasm_compiler} ${ARGN} ${exception_flags} -x c++-header ${CMAKE_BINARY_DIR}/wasm/headers.h -o ${precompiled}
    DEPENDS ${CMAKE_BINARY_DIR}/wasm/headers.h
    COMMENT "Compiling the standard headers for WebAssembly"
    VERBATIM)
endfunction()

# Stores a name for the object of core/FOLDER/NAME.cpp in `name`: folders have files of the same name.
function(wasm_name name source)
  string(REGEX REPLACE "^core/|[.]cpp$" "" own ${source})
  string(REPLACE "/" "." own ${own})
  set(${name} ${own} PARENT_SCOPE)
endfunction()

# Compiles `source` to wasm/NAME.o, with further flags, and adds that object to the list `objects`.
function(compile_wasm objects name source)
  set(object ${CMAKE_BINARY_DIR}/wasm/${name}.o)
  set(parsed)
  if(source MATCHES "/core/.*[.]cpp$")
    precompile_standard_headers(parsed ${ARGN})
  endif()
  add_custom_command(
    OUTPUT ${object}
    COMMAND ${wasm_compiler} ${ARGN} ${exception_flags} "$<$<BOOL:${parsed}>:-Xclang;-include-pch;-Xclang;${parsed}>"
      -MD -MF ${object}.d -c ${source} -o ${object}
    DEPENDS ${source} ${parsed}
    DEPFILE ${object}.d
    COMMENT "Compiling ${name} for WebAssembly"
    COMMAND_EXPAND_LISTS
    VERBATIM)
  set(${objects} ${${objects}} ${object} PARENT_SCOPE)
endfunction()

list(TRANSFORM standard_headers PREPEND "#include " OUTPUT_VARIABLE includes)
list(JOIN includes "\n" includes)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/wasm/headers.h CONTENT "${includes}\n")
# First, so that the library's own parts are not taken.
compile_wasm(runtime runtime ${PROJECT_SOURCE_DIR}/bindings/wasm_runtime.cpp ${wasm_flags})
compile_wasm(runtime unwind ${zig}/lib/libunwind/src/Unwind-wasm.c -x c -O2 -w -DNDEBUG -D_LIBUNWIND_HIDE_SYMBOLS -matomics -mbulk-memory -I ${zig}/lib/libunwind/include)
foreach(name cxa_exception cxa_personality)
  compile_wasm(runtime ${name} ${zig}/lib/libcxxabi/src/${name}.cpp ${libcxxabi_flags})
endforeach()
foreach(part completion tracing light)
  foreach(source ${${part}_sources})
    wasm_name(name ${source})
    set(further_flags ${small_flags})
    if(source IN_LIST fast_sources)
      set(further_flags)
    endif()
    compile_wasm(${part}_objects ${name} ${PROJECT_SOURCE_DIR}/${source} ${wasm_flags} ${further_flags})
  endforeach()
  foreach(source ${${part}_kernels})
    wasm_name(name ${source})
    set(kernel_flags ${wasm_flags} ${${part}_kernel_flags})
    if(source MATCHES "/history_kernels|/shade_kernels")
      list(APPEND kernel_flags ${small_flags}) # they wait for memory
    endif()
    compile_wasm(${part}_simd128 ${name} ${PROJECT_SOURCE_DIR}/${source} ${kernel_flags})
    compile_wasm(${part}_relaxed ${name}.relaxed ${PROJECT_SOURCE_DIR}/${source} ${kernel_flags} -mrelaxed-simd)
  endforeach()
endforeach()
compile_wasm(one_thread parallel_single ${PROJECT_SOURCE_DIR}/core/base/parallel_single.cpp ${wasm_flags})
compile_wasm(threads parallel_lent ${PROJECT_SOURCE_DIR}/core/base/parallel_lent.cpp ${wasm_flags})
compile_wasm(runtime_of_threads wasm_threads ${PROJECT_SOURCE_DIR}/bindings/wasm_threads.cpp ${wasm_flags})
compile_wasm(completion_objects wasm_completion ${PROJECT_SOURCE_DIR}/bindings/wasm_completion.cpp ${wasm_flags} ${small_flags})
compile_wasm(tracing_objects wasm ${PROJECT_SOURCE_DIR}/bindings/wasm.cpp ${wasm_flags} ${small_flags})
compile_wasm(tracing_objects wasm_parts ${PROJECT_SOURCE_DIR}/bindings/wasm_parts.cpp ${wasm_flags} ${small_flags})
compile_wasm(reading_objects wasm_reading ${PROJECT_SOURCE_DIR}/bindings/wasm_reading.cpp ${wasm_flags} ${small_flags})
compile_wasm(files_objects wasm_files ${PROJECT_SOURCE_DIR}/bindings/wasm_files.cpp ${wasm_flags} ${small_flags})
compile_wasm(light_objects wasm_light ${PROJECT_SOURCE_DIR}/bindings/wasm_light.cpp ${wasm_flags} ${small_flags})
compile_wasm(shapes_objects wasm_shapes ${PROJECT_SOURCE_DIR}/bindings/wasm_shapes.cpp ${wasm_flags} ${small_flags})
compile_wasm(shapes_objects wasm_3mf ${PROJECT_SOURCE_DIR}/bindings/wasm_3mf.cpp ${wasm_flags} ${small_flags})
compile_wasm(drawing_objects wasm_drawing ${PROJECT_SOURCE_DIR}/bindings/wasm_drawing.cpp ${wasm_flags} ${small_flags})

# One machine for all modules, with atomics: zig compiles its C and C++ libraries once for each machine, for a minute.
set(machine -mcpu=generic+atomics+bulk_memory+mutable_globals)

# Links objects to the module NAME.wasm, with `link_flags`.
function(link_wasm name)
  set(module ${CMAKE_BINARY_DIR}/wasm/${name}.wasm)
  add_custom_command(
    OUTPUT ${module}
    COMMAND ${wasm_compiler} -mexec-model=reactor -O3 -s ${machine} ${link_flags} ${runtime} ${ARGN} -o ${module}
    DEPENDS ${runtime} ${ARGN}
    COMMENT "Linking ${name}.wasm"
    VERBATIM)
  set(wasm_modules ${wasm_modules} ${module} PARENT_SCOPE)
endfunction()

set(of_one ${completion_objects} ${one_thread})
link_wasm(complete ${of_one} ${completion_simd128})
link_wasm(complete.relaxed ${of_one} ${completion_relaxed})
# Links the cores for instructions of SET. The linker leaves unused code out: core.mesh has no shapes except meshes; it has lights,
# and draws and finds edges, only as core.mesh.light; only these two read files of meshes, and core reads 3MF, which may have other shapes.
macro(link_cores name set)
  set(core ${completion_${set}} ${tracing_objects} ${tracing_${set}})
  set(light ${light_objects} ${light_${set}})
  link_wasm(core${name} ${ARGN} ${core} ${reading_objects} ${shapes_objects} ${drawing_objects} ${light})
  link_wasm(core.mesh${name} ${ARGN} ${core} ${reading_objects} ${files_objects})
  link_wasm(core.mesh.light${name} ${ARGN} ${core} ${reading_objects} ${files_objects} ${drawing_objects} ${light})
endmacro()
link_cores("" simd128 ${of_one})
link_cores(.relaxed relaxed ${of_one})

# Memory is as viewer/core/core.js makes it; what replaces the library's own comes before whoever asks for it.
set(link_flags -Wl,--shared-memory -Wl,--import-memory
  -Wl,--initial-memory=33554432 -Wl,--max-memory=4294901760 -Wl,--export=__stack_pointer)
list(INSERT runtime 1 ${runtime_of_threads})
link_cores(.threads.relaxed relaxed ${threads} ${completion_objects})
add_custom_target(wasm ALL DEPENDS ${wasm_modules})
install(FILES ${wasm_modules} DESTINATION ${viewer})
