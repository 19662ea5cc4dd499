# LibTorch by hand, for our own build and, installed, for find_package(diffsac).

# diffsac_find_libtorch(OUT folder...): the root of the first LibTorch among the folders, each of which may be the root
# itself, its share/cmake/Torch or the folder above; empty when there is none. Nothing is cached: another folder given
# later counts at once.
function(diffsac_find_libtorch out)
  foreach(folder ${ARGN})
    foreach(root ${folder} ${folder}/../../.. ${folder}/torch ${folder}/libtorch)
      if(EXISTS ${root}/include/torch/csrc/api/include/torch/torch.h AND EXISTS ${root}/lib/libtorch_cpu.so)
        get_filename_component(root ${root} REALPATH)
        set(${out} ${root} PARENT_SCOPE)
        return()
      endif()
    endforeach()
  endforeach()
  set(${out} "" PARENT_SCOPE)
endfunction()

# diffsac_libtorch_version(ROOT OUT): "2.11.0", or "of unknown version".
function(diffsac_libtorch_version root out)
  set(numbers)
  foreach(header torch/headeronly/version.h torch/csrc/api/include/torch/version.h)
    if(NOT numbers AND EXISTS ${root}/include/${header})
      file(STRINGS ${root}/include/${header} lines REGEX "#define TORCH_VERSION_(MAJOR|MINOR|PATCH) [0-9]+")
      foreach(line ${lines})
        string(REGEX MATCH "[0-9]+$" number ${line})
        list(APPEND numbers ${number})
      endforeach()
    endif()
  endforeach()
  list(JOIN numbers "." version)
  if(NOT version)
    set(version "of unknown version")
  endif()
  set(${out} ${version} PARENT_SCOPE)
endfunction()

# diffsac_libtorch_folders(ROOT OUT): the folders that hold shared libraries; the wheel's CUDA runtime stands beside it.
function(diffsac_libtorch_folders root out)
  file(GLOB runtime ${root}/../nvidia/*/lib)
  set(folders ${root}/lib)
  foreach(folder ${runtime})
    get_filename_component(folder ${folder} REALPATH)
    list(APPEND folders ${folder})
  endforeach()
  set(${out} ${folders} PARENT_SCOPE)
endfunction()

# diffsac_libtorch_flags(ROOT CUDA INCLUDES LIBRARIES LINK_OPTIONS): what a user of LibTorch compiles and links with.
function(diffsac_libtorch_flags root cuda includes libraries link_options)
  set(${includes} ${root}/include ${root}/include/torch/csrc/api/include PARENT_SCOPE)
  set(libs ${root}/lib/libtorch_cpu.so ${root}/lib/libc10.so)
  if(cuda)
    set(lib ${root}/lib)
    list(APPEND libs -Wl,--no-as-needed,${lib}/libtorch_cuda.so,${lib}/libc10_cuda.so,${lib}/libtorch.so,--as-needed)
  endif()
  set(${libraries} ${libs} PARENT_SCOPE)
  # libtorch_cpu.so itself needs the CUDA runtime, which the linker must find.
  diffsac_libtorch_folders(${root} folders)
  list(POP_FRONT folders)
  list(TRANSFORM folders PREPEND -Wl,-rpath-link,)
  set(${link_options} ${folders} PARENT_SCOPE)
endfunction()
