// SPDX-License-Identifier: LGPL-3.0-or-later
#include "threads.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

namespace fretfe {
namespace {

// Helpers look for more work so long before they sleep: waking one takes as long as a product of a
// matrix with a vector, and the next one follows soon. Whoever else wants the core gets it.
constexpr std::chrono::microseconds awake{1000};

std::atomic<std::size_t> allowed{1};

/// Threads that wait for work. Those that come late find their places taken back: nobody waits for
/// a thread whose core another process has.
class Helpers {
public:
  /// Never destroyed: its threads end with the process.
  static Helpers &all() {
    static auto *found = new Helpers;
    return *found;
  }

  void help(std::size_t count, const std::function<void()> &work) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      hire(count);
      work_ = &work;
      places_ = count;
      ++rounds_;
    }
    if (asleep_ > 0)
      changed_.notify_all();
    work();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      places_ = 0;
    }
    while (busy_ > 0)
      std::this_thread::yield();
  }

private:
  void hire(std::size_t count) {
    try {
      for (; hired_ < count; ++hired_)
        std::thread([this, seen = rounds_.load()] { serve(seen); }).detach();
    } catch (const std::system_error &) { // the system gives no more
    }
  }

  void serve(std::size_t seen) {
    while (true) {
      await(seen);
      std::unique_lock<std::mutex> lock(mutex_);
      seen = rounds_;
      if (places_ == 0)
        continue;
      --places_;
      ++busy_;
      const auto *work = work_;
      lock.unlock();
      (*work)();
      --busy_;
    }
  }

  void await(std::size_t seen) {
    const auto until = std::chrono::steady_clock::now() + awake;
    while (rounds_ == seen && std::chrono::steady_clock::now() < until)
      std::this_thread::yield();
    std::unique_lock<std::mutex> lock(mutex_);
    ++asleep_;
    while (rounds_ == seen) // `wait` would need the C++ library of GCC 12, which some have not
      changed_.wait_for(lock, std::chrono::seconds(1));
    --asleep_;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()> *work_ = nullptr;
  std::size_t hired_ = 0, places_ = 0;
  std::atomic<std::size_t> rounds_{0}, busy_{0}, asleep_{0};
};

} // namespace

void use_threads(int count) { allowed = static_cast<std::size_t>(std::max(count, 1)); }

std::size_t threads() { return allowed; }

void on_threads(std::size_t count, const std::function<void()> &work) {
  count = std::min(count, threads());
  if (count > 1)
    Helpers::all().help(count - 1, work);
  else
    work();
}

void for_each(std::size_t count, const std::function<void(std::size_t)> &work) {
  std::atomic<std::size_t> next{0};
  on_threads(count, [&] {
    for (std::size_t i = next++; i < count; i = next++)
      work(i);
  });
}

} // namespace fretfe
