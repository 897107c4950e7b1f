/// load FILE: loads a native module of Python without Python, which runs what the module sets up before its first call.
#include <stdio.h>
#include <windows.h>

int main(int count, char** arguments) {
    HMODULE module = count == 2 ? LoadLibraryA(arguments[1]) : NULL;
    if (!module) return printf("not loaded, error %lu\n", GetLastError()), 1;
    if (!GetProcAddress(module, "PyInit__core")) return printf("loaded, without PyInit__core\n"), 1;
    return printf("loaded, with PyInit__core\n"), 0;
}
