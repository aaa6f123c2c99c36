#include "src/base/threads.hpp"
#include <system_error>
#include <utility>

namespace quern {
namespace {

// Steps are microseconds to milliseconds apart, and to wake a sleeping thread takes tens of microseconds: so threads wait
// awake for some hundreds of them before they sleep.
constexpr int patience = 20000;

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");
#endif
}

template <class Condition>
void spin_until(Condition&& done) {
  for (int spins = 0; !done(); ++spins) {
    pause();
    if (spins > patience) std::this_thread::yield();
  }
}

}  // namespace

ThreadTeam::ThreadTeam(int threads) : shares_(static_cast<std::size_t>(threads > 1 ? threads : 1)) {
  workers_.reserve(static_cast<std::size_t>(threads > 1 ? threads - 1 : 0));
  try {
    for (int k = 1; k < threads; ++k) workers_.emplace_back([this, k] { serve(k); });
  } catch (const std::system_error&) {
    // The system gives no more of them: those that there are do the same work.
  }
}

ThreadTeam::~ThreadTeam() {
  stop_.store(true);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadTeam::run_shared(int blocks, const std::function<void(int)>& work) {
  work_ = &work;
  for (int k = 0; k < size(); ++k) {
    Share& share = shares_[static_cast<std::size_t>(k)];
    share.next.store(static_cast<int>(static_cast<std::int64_t>(blocks) * k / size()), std::memory_order_relaxed);
    share.end = static_cast<int>(static_cast<std::int64_t>(blocks) * (k + 1) / size());
  }
  idle_.store(0, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  take_blocks(0);
  const int others = static_cast<int>(workers_.size());
  spin_until([&] { return idle_.load(std::memory_order_acquire) == others; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void ThreadTeam::take_blocks(int me) {
  for (int k = 0; k < size(); ++k) {
    Share& share = shares_[static_cast<std::size_t>((me + k) % size())];
    for (int block; (block = share.next.fetch_add(1, std::memory_order_relaxed)) < share.end;) {
      try {
        (*work_)(block);
      } catch (...) {
        const std::lock_guard lock(error_guard_);
        if (!error_ || block < error_block_) error_ = std::current_exception(), error_block_ = block;
      }
    }
  }
}

void ThreadTeam::serve(int me) {
  std::uint32_t seen = 0;
  for (;;) {
    for (int spins = 0; round_.load(std::memory_order_acquire) == seen; ++spins) {
      pause();
      if (spins > patience) round_.wait(seen, std::memory_order_acquire);
    }
    seen = round_.load(std::memory_order_acquire);
    if (stop_.load()) return;
    take_blocks(me);
    idle_.fetch_add(1, std::memory_order_release);
  }
}

}  // namespace quern
