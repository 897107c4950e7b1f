/// The configuration of CPython on 64-bit Windows, as far as headers of the stable ABI ask for it. An installed Python of
/// Windows brings its own; here the headers are those of this machine's Python, whose other files are the same.
#pragma once

#define MS_WIN32
#define MS_WIN64
#define MS_WINDOWS
#define NT_THREADS
#define WITH_THREAD
#define Py_ENABLE_SHARED

#define ALIGNOF_MAX_ALIGN_T 8
#define ALIGNOF_SIZE_T 8
#define SIZEOF_DOUBLE 8
#define SIZEOF_FLOAT 4
#define SIZEOF_INT 4
#define SIZEOF_LONG 4
#define SIZEOF_LONG_LONG 8
#define SIZEOF_PID_T 4
#define SIZEOF_SHORT 2
#define SIZEOF_SIZE_T 8
#define SIZEOF_TIME_T 8
#define SIZEOF_VOID_P 8
#define SIZEOF_WCHAR_T 2
#define SIZEOF__BOOL 1

#define HAVE_STDDEF_H
#define HAVE_SYS_STAT_H
#define HAVE_SYS_TYPES_H
#define HAVE_UINTPTR_T
#define HAVE_WCHAR_H
#define HAVE_DECL_ISFINITE
#define HAVE_DECL_ISINF
#define HAVE_DECL_ISNAN
#define HAVE_ERRNO_H
#define STDC_HEADERS
