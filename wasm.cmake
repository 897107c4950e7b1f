# The core as WebAssembly modules, for the viewer's page: viewer/core.wasm in simd128 and viewer/core.relaxed.wasm in
# relaxed-simd, both again without shapes other than meshes, viewer/core.mesh*.wasm, which have lights as viewer/core.mesh.light*.wasm,
# and with the networks alone, viewer/complete*.wasm. In viewer/core*.threads.relaxed.wasm, threads share memory. Compiled by the clang of the wheel
# `ziglang`; without that wheel, the package is built without them.
#
# The first build on a machine compiles zig's C library, which takes half a minute; zig keeps it in its own cache. Of its C++ library,
# which would take another minute, only the sources that the modules need are compiled; zig itself leaves those of exceptions out.
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
# Zig itself takes -Oz for -Os.
set(small_flags -Os -Xclang -Oz)
set(exception_flags -fwasm-exceptions -mexception-handling -mllvm -wasm-use-legacy-eh=false)
set(library_flags ${small_flags} -std=c++23 -w -fvisibility=hidden -matomics -mbulk-memory -DNDEBUG -D_LIBCPP_BUILDING_LIBRARY
  -D_LIBCXXABI_BUILDING_LIBRARY -DLIBCXX_BUILDING_LIBCXXABI -D_LIBCXXABI_HAS_NO_THREADS -DLIBCXXABI_NON_DEMANGLING_TERMINATE
  -DLIBC_NAMESPACE=__llvm_libc_common_utils -I ${zig}/lib/libcxxabi/include -I ${zig}/lib/libcxx/src -I ${zig}/lib/libcxx/libc)

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
  if("-DBOB_ISA=baseline" IN_LIST ARGN) # not those of zig's libraries
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
# An archive, whose parts bindings/wasm_threads.cpp may replace.
foreach(name abort_message cxa_aux_runtime cxa_default_handlers cxa_exception cxa_exception_storage cxa_guard cxa_handlers cxa_personality
    cxa_virtual fallback_malloc private_typeinfo stdlib_exception stdlib_stdexcept stdlib_typeinfo)
  compile_wasm(library_objects libcxxabi.${name} ${zig}/lib/libcxxabi/src/${name}.cpp ${library_flags})
endforeach()
foreach(name algorithm charconv exception functional hash memory new new_handler new_helpers optional ryu/d2fixed ryu/d2s ryu/f2s
    stdexcept string variant)
  get_filename_component(object ${name} NAME)
  compile_wasm(library_objects libcxx.${object} ${zig}/lib/libcxx/src/${name}.cpp ${library_flags})
endforeach()
set(library ${CMAKE_BINARY_DIR}/wasm/libcxx.a)
add_custom_command(
  OUTPUT ${library}
  COMMAND ${CMAKE_COMMAND} -E rm -f ${library}
  COMMAND ${Python_EXECUTABLE} -m ziglang ar qcs ${library} ${library_objects}
  DEPENDS ${library_objects}
  COMMENT "Archiving the C++ library for WebAssembly"
  VERBATIM)
foreach(part completion tracing light)
  set(groups)
  foreach(source ${${part}_sources})
    if(source IN_LIST hot_sources)
      set(size fast)
      set(size_flags)
    else()
      set(size small)
      set(size_flags ${small_flags})
    endif()
    if(BOBROSSNET_UNITY)
      group_source(group ${part}_${size} ${source})
    else()
      wasm_name(group ${source})
    endif()
    list(APPEND groups ${group})
    string(APPEND includes_of_${group} "#include \"${PROJECT_SOURCE_DIR}/${source}\"\n")
    set(flags_of_${group} ${size_flags})
  endforeach()
  list(REMOVE_DUPLICATES groups)
  foreach(group ${groups})
    set(source ${CMAKE_BINARY_DIR}/wasm/${group}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "${includes_of_${group}}")
    compile_wasm(${part}_objects ${group} ${source} ${wasm_flags} ${flags_of_${group}})
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

# One machine for all modules, with atomics: zig compiles its C library once for each machine.
set(machine -mcpu=generic+atomics+bulk_memory+mutable_globals)

# Links objects to the module NAME.wasm, with `link_flags`.
function(link_wasm name)
  set(module ${CMAKE_BINARY_DIR}/wasm/${name}.wasm)
  add_custom_command(
    OUTPUT ${module}
    COMMAND ${wasm_compiler} -mexec-model=reactor -O3 -s ${machine} ${link_flags} ${runtime} ${ARGN} -nostdlib++ ${library} -o ${module}
    DEPENDS ${runtime} ${ARGN} ${library}
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
