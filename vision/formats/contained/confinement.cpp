#include "vision/formats/contained/confinement.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <vector>

namespace tribotrack::vision {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{4} << 30;  ///< bytes: one picture of the largest size takes 1

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;  // not filtered
#endif

/// Memory, files that are open, time, waiting, and the end. What else is asked for fails with EPERM.
constexpr long kAllowed[] = {
    SYS_read,         SYS_pread64,   SYS_readv,        SYS_lseek,          SYS_fcntl,
    SYS_close,        SYS_fstat,     SYS_statx,        SYS_faccessat,      SYS_readlinkat,
    SYS_getdents64,   SYS_getcwd,    SYS_mmap,         SYS_munmap,         SYS_mremap,
    SYS_mprotect,     SYS_madvise,   SYS_brk,          SYS_futex,          SYS_clock_gettime,
    SYS_gettimeofday, SYS_getrusage, SYS_getrandom,    SYS_sched_yield,    SYS_sched_getaffinity,
    SYS_getpid,       SYS_gettid,    SYS_rt_sigaction, SYS_rt_sigprocmask, SYS_rt_sigreturn,
    SYS_sendto,       SYS_recvfrom,  SYS_ppoll,        SYS_exit,           SYS_exit_group,
#ifdef SYS_newfstatat
    SYS_newfstatat,
#endif
#ifdef SYS_poll  // of older architectures
    SYS_poll,         SYS_stat,      SYS_lstat,        SYS_access,         SYS_readlink,
    SYS_time,
#endif
};

using Instruction = sock_filter;

Instruction load(std::size_t at) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(at));
}

Instruction answer(std::uint32_t what) {
  return BPF_STMT(BPF_RET | BPF_K, what);
}

/// Leaves out the next `count` instructions unless what was loaded is `value`.
Instruction only_if(long value, unsigned char count) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(value), 0, count);
}

/// A call that is allowed where these bits of one of its arguments are 0.
struct Allowed {
  long call;
  std::size_t argument;
  std::uint32_t bits;
};
constexpr Allowed kAllowedIf[] = {
    {SYS_openat, 2, O_ACCMODE | O_CREAT | O_TRUNC},  // flags: only to read
    {SYS_prlimit64, 0, ~0U},                         // process: only its own limits
};

void filter_system_calls() {
  if (kArchitecture == 0) return;
  constexpr std::uint32_t kRefused = SECCOMP_RET_ERRNO | EPERM;
  // Calls by another architecture's numbers are not what they seem.
  std::vector<Instruction> program = {load(offsetof(seccomp_data, arch)), only_if(kArchitecture, 1),
                                      BPF_STMT(BPF_JMP | BPF_JA, 1), answer(kRefused),
                                      load(offsetof(seccomp_data, nr))};
  for (const long call : kAllowed) {
    program.push_back(only_if(call, 1));
    program.push_back(answer(SECCOMP_RET_ALLOW));
  }
  for (const Allowed& allowed : kAllowedIf) {
    const std::size_t low = offsetof(seccomp_data, args) + allowed.argument * sizeof(std::uint64_t);
    for (const Instruction& next :
         {only_if(allowed.call, 5), load(low), Instruction BPF_STMT(BPF_ALU | BPF_AND | BPF_K, allowed.bits),
          only_if(0, 1), answer(SECCOMP_RET_ALLOW), answer(kRefused)})
      program.push_back(next);
  }
  program.push_back(answer(kRefused));
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0)
    ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &filter);
}

/// Address space that the process has already.
std::uint64_t bytes_held() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void lower(__rlimit_resource resource, std::uint64_t most) {
  rlimit limit{};
  ::getrlimit(resource, &limit);
  limit.rlim_cur = std::min<rlim_t>(most, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

}  // namespace

void confine_to_reading(int first_closed) {
  // What the terminal sends it sends to the parent, too; a parent that is gone is seen at the socket.
  ::signal(SIGINT, SIG_IGN);
  for (const int fatal : {SIGTERM, SIGHUP, SIGXCPU}) ::signal(fatal, SIG_DFL);
  const int nothing = ::open("/dev/null", O_RDWR);
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) ::dup2(nothing, stream);
  ::close_range(static_cast<unsigned>(first_closed), ~0U, 0);
  lower(RLIMIT_AS, bytes_held() + kMemory);
  lower(RLIMIT_CORE, 0);
  filter_system_calls();
}

void allow_cpu(std::uint64_t seconds) {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  lower(RLIMIT_CPU, static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + seconds);
}

std::string end_in_words(int status) {
  if (!WIFSIGNALED(status)) return "ends its decoder";
  if (WTERMSIG(status) == SIGXCPU) return "keeps its decoder busy without end";
  if (WTERMSIG(status) == SIGKILL) return "cannot be decoded in the time and the memory that there are";
  return fmt::format("crashes its decoder (signal {}, {})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
}

}  // namespace tribotrack::vision
