/* Calls that write fail when they are told to: loaded before the C library by LD_PRELOAD, on Linux.

   Counted are the calls that change what lies below one of some folders: writing, making, renaming, flushing. They
   are counted in a file that all processes of a command share, so that workers count on where the command was. What
   is to fail is told by the environment (or by faults_begin, for a process that was forked and not started):

   FAULTS_BELOW   the folders, absolute and resolved, with : between them
   FAULTS_COUNT   a file of 8 bytes, the number of calls so far
   FAULTS_LOG     a file that gets a line "KIND PATH" for each call; empty for none
   FAULTS_AT      the number of the call that fails, from 1; 0 for none
   FAULTS_ERRNO   what it fails with; -1: a write is cut short to one byte instead; -100 - SIGNAL: the process gets it
   FAULTS_MORE    1: every later call fails as well, as on a full disk
*/
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static char below[4096], log_path[PATH_MAX];
static atomic_long *count;
static long at;
static int number, more;

static void begin(const char *folders, const char *counter, const char *log, long first, int code, int later) {
    count = NULL;
    snprintf(below, sizeof below, "%s", folders ? folders : "");
    snprintf(log_path, sizeof log_path, "%s", log ? log : "");
    at = first, number = code, more = later;
    if (!below[0] || !counter || !counter[0]) return;
    int fd = syscall(SYS_openat, AT_FDCWD, counter, O_RDWR | O_CLOEXEC, 0);
    if (fd < 0) return;
    void *page = mmap(NULL, sizeof(atomic_long), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    syscall(SYS_close, fd);
    if (page != MAP_FAILED) count = page;
}

static long asked(const char *name) {
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

__attribute__((constructor)) void faults_begin(void) {
    begin(getenv("FAULTS_BELOW"), getenv("FAULTS_COUNT"), getenv("FAULTS_LOG"), asked("FAULTS_AT"),
          (int)asked("FAULTS_ERRNO"), (int)asked("FAULTS_MORE"));
}

static int lies_below(const char *path) {
    for (const char *folder = below; *folder;) {
        size_t length = strcspn(folder, ":");
        if (length && !strncmp(path, folder, length) && (path[length] == '/' || !path[length])) return 1;
        folder += length + (folder[length] == ':');
    }
    return 0;
}

static int path_of(int fd, char *out) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, link, out, PATH_MAX - 1);
    if (length <= 0) return 0;
    out[length] = 0;
    return 1;
}

static int absolute(int folder, const char *path, char *out) {
    if (!path) return 0;
    if (path[0] == '/') return snprintf(out, PATH_MAX, "%s", path) < PATH_MAX;
    char base[PATH_MAX];
    if (folder == AT_FDCWD) {
        ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, "/proc/self/cwd", base, PATH_MAX - 1);
        if (length <= 0) return 0;
        base[length] = 0;
    } else if (!path_of(folder, base)) {
        return 0;
    }
    return snprintf(out, PATH_MAX, "%s/%s", base, path) < PATH_MAX;
}

/* Count a call; return 1 and set errno where it is to fail, -1 where it is to be cut short, 0 where it goes on. */
static int fails(const char *kind, const char *path) {
    if (!count || !lies_below(path)) return 0;
    long now = atomic_fetch_add(count, 1) + 1;
    if (log_path[0]) {
        char line[PATH_MAX + 32];
        int length = snprintf(line, sizeof line, "%s %s\n", kind, path);
        int fd = syscall(SYS_openat, AT_FDCWD, log_path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
        if (fd >= 0) {
            syscall(SYS_write, fd, line, length);
            syscall(SYS_close, fd);
        }
    }
    if (!at || now < at || (now > at && !more)) return 0;
    if (number <= -100) {
        kill(getpid(), -100 - number);
        return 0;
    }
    if (number == -1) return -1;
    errno = number;
    return 1;
}

static int fd_fails(const char *kind, int fd) {
    char path[PATH_MAX];
    int before = errno, failed = count && path_of(fd, path) ? fails(kind, path) : 0;
    if (failed != 1) errno = before;
    return failed;
}

static int name_fails(const char *kind, int folder, const char *name) {
    char path[PATH_MAX];
    int before = errno, failed = count && absolute(folder, name, path) ? fails(kind, path) : 0;
    if (failed != 1) errno = before;
    return failed == 1;  /* there is nothing to cut short */
}

#define REAL(name) \
    static __typeof__(&name) real; \
    if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)
#define SHORTENED(size) (failed < 0 && (size) > 1 ? 1 : (size))

ssize_t write(int fd, const void *data, size_t size) {
    REAL(write);
    int failed = fd_fails("write", fd);
    return failed > 0 ? -1 : real(fd, data, SHORTENED(size));
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t where) {
    REAL(pwrite);
    int failed = fd_fails("write", fd);
    return failed > 0 ? -1 : real(fd, data, SHORTENED(size), where);
}

ssize_t pwrite64(int fd, const void *data, size_t size, off64_t where) {
    REAL(pwrite64);
    int failed = fd_fails("write", fd);
    return failed > 0 ? -1 : real(fd, data, SHORTENED(size), where);
}

ssize_t writev(int fd, const struct iovec *parts, int length) {
    REAL(writev);
    int failed = fd_fails("write", fd);
    if (failed < 0 && parts[0].iov_len > 1) return write(fd, parts[0].iov_base, 1);
    return failed > 0 ? -1 : real(fd, parts, length);
}

ssize_t sendfile(int to, int from, off_t *where, size_t size) {
    REAL(sendfile);
    int failed = fd_fails("write", to);
    return failed > 0 ? -1 : real(to, from, where, SHORTENED(size));
}

ssize_t sendfile64(int to, int from, off64_t *where, size_t size) {
    REAL(sendfile64);
    int failed = fd_fails("write", to);
    return failed > 0 ? -1 : real(to, from, where, SHORTENED(size));
}

ssize_t copy_file_range(int from, off64_t *there, int to, off64_t *here, size_t size, unsigned flags) {
    REAL(copy_file_range);
    int failed = fd_fails("write", to);
    return failed > 0 ? -1 : real(from, there, to, here, SHORTENED(size), flags);
}

int ftruncate(int fd, off_t size) {
    REAL(ftruncate);
    return fd_fails("ftruncate", fd) > 0 ? -1 : real(fd, size);
}

int ftruncate64(int fd, off64_t size) {
    REAL(ftruncate64);
    return fd_fails("ftruncate", fd) > 0 ? -1 : real(fd, size);
}

int fsync(int fd) {
    REAL(fsync);
    return fd_fails("fsync", fd) > 0 ? -1 : real(fd);
}

int fdatasync(int fd) {
    REAL(fdatasync);
    return fd_fails("fsync", fd) > 0 ? -1 : real(fd);
}

#define MAKES (flags & (O_CREAT | O_TRUNC) && (flags & O_ACCMODE) != O_RDONLY)
#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | __O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, flags); \
        mode = va_arg(rest, mode_t); \
        va_end(rest); \
    }

int open(const char *path, int flags, ...) {
    REAL(open);
    MODE
    return MAKES && name_fails("open", AT_FDCWD, path) ? -1 : real(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
    REAL(open64);
    MODE
    return MAKES && name_fails("open", AT_FDCWD, path) ? -1 : real(path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...) {
    REAL(openat);
    MODE
    return MAKES && name_fails("open", folder, path) ? -1 : real(folder, path, flags, mode);
}

int openat64(int folder, const char *path, int flags, ...) {
    REAL(openat64);
    MODE
    return MAKES && name_fails("open", folder, path) ? -1 : real(folder, path, flags, mode);
}

/* What is there already is said to be there, even on a full disk. */
static int is_there(int folder, const char *path) {
    int before = errno, there = !syscall(SYS_faccessat, folder, path, F_OK);
    errno = before;
    return there;
}

int mkdir(const char *path, mode_t mode) {
    REAL(mkdir);
    return !is_there(AT_FDCWD, path) && name_fails("mkdir", AT_FDCWD, path) ? -1 : real(path, mode);
}

int mkdirat(int folder, const char *path, mode_t mode) {
    REAL(mkdirat);
    return !is_there(folder, path) && name_fails("mkdir", folder, path) ? -1 : real(folder, path, mode);
}

int rename(const char *from, const char *to) {
    REAL(rename);
    return name_fails("rename", AT_FDCWD, to) ? -1 : real(from, to);
}

int renameat(int one, const char *from, int other, const char *to) {
    REAL(renameat);
    return name_fails("rename", other, to) ? -1 : real(one, from, other, to);
}

int renameat2(int one, const char *from, int other, const char *to, unsigned flags) {
    REAL(renameat2);
    return name_fails("rename", other, to) ? -1 : real(one, from, other, to, flags);
}
