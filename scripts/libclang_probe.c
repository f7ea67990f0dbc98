/* libclang_probe LIBRARY FILE [ARGUMENT...]: exit status 0 if the library is a libclang that reads FILE, given these
 * arguments, and has nothing to remark. install.sh gives it this file, which includes a header of the compiler's own as
 * Ipopt's do. */
#include <dlfcn.h>
#include <stddef.h>

typedef void *(*create_index)(int, int);
typedef void *(*parse_translation_unit)(void *, const char *, char **, int, void *, unsigned, unsigned);
typedef unsigned (*get_num_diagnostics)(void *);

int main(int argc, char **argv) {
    void *library = argc > 2 ? dlopen(argv[1], RTLD_NOW) : NULL;
    if (!library) return 1;
    create_index create = (create_index)dlsym(library, "clang_createIndex");
    parse_translation_unit parse = (parse_translation_unit)dlsym(library, "clang_parseTranslationUnit");
    get_num_diagnostics remarks = (get_num_diagnostics)dlsym(library, "clang_getNumDiagnostics");
    if (!create || !parse || !remarks) return 1;
    void *unit = parse(create(0, 0), argv[2], argv + 3, argc - 3, NULL, 0, 0);
    return !unit || remarks(unit) > 0;
}
