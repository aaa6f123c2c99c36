// A team of threads that stays alive between steps. Work is cut into blocks whose number does not depend on the team,
// and each block writes only what is its own, so that results do not depend on the number of threads. Each thread begins with the
// same share of the blocks every time, whose data are in its cache, and helps the others when that is done.
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace quern {

class ThreadTeam {
 public:
  // Fewer where the system gives no more.
  explicit ThreadTeam(int threads = 1);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int size() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls work(block) once for each block in [0, blocks) and returns when all are done. Where blocks throw, throws what the first
  // of them threw; the others may have been done or not.
  template <class Work>
  void run(int blocks, Work&& work) {
    if (workers_.empty() || blocks < 2) {
      for (int block = 0; block < blocks; ++block) work(block);
      return;
    }
    run_shared(blocks, [&work](int block) { work(block); });
  }

 private:
  void run_shared(int blocks, const std::function<void(int)>& work);
  void take_blocks(int me);
  void serve(int me);

  std::vector<std::thread> workers_;
  const std::function<void(int)>* work_ = nullptr;
  struct alignas(64) Share {
    std::atomic<int> next{0};  // block to do
    int end = 0;
  };
  std::vector<Share> shares_;
  std::atomic<int> idle_{0};
  std::atomic<std::uint32_t> round_{0};
  std::atomic<bool> stop_{false};
  std::mutex error_guard_;
  std::exception_ptr error_;
  int error_block_ = 0;
};

}  // namespace quern
