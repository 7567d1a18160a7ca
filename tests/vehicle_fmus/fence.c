/* To be preloaded: finds every use after delete of a C++ object of 128 bytes, the size of the block in
 * which pythonfmu's library keeps its interpreter.
 *
 * Each such object gets a page of its own, which nobody may touch any more once it is deleted and which
 * is never used again. A process that touches it ends by SIGSEGV, always, where without the fence it
 * aborts now and then. */
#define _GNU_SOURCE
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { SIZE = 128, PAGE = 4096, PAGES = 1 << 14 }; /* each may be a mapping of its own: 65530 at most */

static char *yard;
static atomic_size_t used;

__attribute__((constructor)) static void fence_off(void) {
    yard = mmap(NULL, (size_t)PAGES * PAGE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (yard == MAP_FAILED) abort();
}

/* operator new(unsigned long) */
void *_Znwm(size_t size) {
    size_t page;
    if (size == SIZE && yard && (page = atomic_fetch_add(&used, 1)) < PAGES) {
        char *object = yard + page * PAGE;
        if (mprotect(object, PAGE, PROT_READ | PROT_WRITE) == 0) return object;
    }
    void *object = malloc(size ? size : 1);
    if (!object) abort(); /* no exceptions here */
    return object;
}

/* operator delete(void *) */
void _ZdlPv(void *object) {
    if (yard && (uintptr_t)object - (uintptr_t)yard < (uintptr_t)PAGES * PAGE) {
        if (mprotect(object, PAGE, PROT_NONE) != 0) abort();
    } else {
        free(object);
    }
}

/* operator delete(void *, unsigned long) */
void _ZdlPvm(void *object, size_t size) {
    (void)size;
    _ZdlPv(object);
}
