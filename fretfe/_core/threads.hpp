// SPDX-License-Identifier: LGPL-3.0-or-later
// Threads that help with one piece of work after the other.
#pragma once

#include <cstddef>
#include <functional>

namespace fretfe {

/// Number of threads of whatever follows, at least 1.
void use_threads(int count);

/// That number.
std::size_t threads();

/// Does `work` on this thread and up to `count` - 1 others at once, as far as these come in time:
/// what there is to do must be shared out in the course of it.
void on_threads(std::size_t count, const std::function<void()> &work);

/// Calls `work(i)` for all i below a number, each on one of the threads.
void for_each(std::size_t count, const std::function<void(std::size_t)> &work);

} // namespace fretfe
