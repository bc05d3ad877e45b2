// What the project uses of oneTBB, made of std::thread, for the preset tsan: ThreadSanitizer knows
// threads, but not what the library, which is not instrumented, does with its tasks, so it takes
// every hand-over of data for a race. CMake puts this file in the place of the headers tbb/*.h.
//
// As with the library, who runs what and in which order is left open, a thread has a number of its
// own within its arena, and a loop within a loop may be run by one thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#define TBB_VERSION_MAJOR 0
#define TBB_VERSION_MINOR 0

namespace tbb {

// Of the arena that a thread works for.
struct ThreadPlace {
  int number = 0, threads = int(std::thread::hardware_concurrency());
  bool in_loop = false;
};
inline thread_local ThreadPlace place;

class task_arena {
 public:
  explicit task_arena(int threads) : threads_(std::max(threads, 1)) {}
  void initialize() {}
  int max_concurrency() const { return threads_; }
  template <class F>
  auto execute(const F& work) -> decltype(work()) {
    struct Restore {
      ThreadPlace before = place;
      ~Restore() { place = before; }
    } const restore;
    place = {.number = 0, .threads = threads_, .in_loop = false};
    return work();
  }

 private:
  int threads_;
};

namespace this_task_arena {
inline int current_thread_index() { return place.number; }
inline int max_concurrency() { return place.threads; }
template <class F>
auto isolate(const F& work) -> decltype(work()) {
  return work();
}
}  // namespace this_task_arena

// Calls piece(i) for every i of [0, count), by all threads of the arena. Rethrows one of the
// exceptions after all of them have ended.
template <class F>
void ForEachPiece(std::size_t count, const F& piece) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto run = [&](ThreadPlace own) {
    place = own;
    try {
      for (std::size_t i; (i = next++) < count;) piece(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      thrown = std::current_exception();
    }
  };
  const ThreadPlace before = place;
  std::vector<std::thread> threads;
  const auto most = before.in_loop ? std::size_t{1} : std::size_t(before.threads);
  for (std::size_t i = 1; i < std::min(most, count); ++i) {
    threads.emplace_back(run, ThreadPlace{int(i), before.threads, true});
  }
  run({before.number, before.threads, true});
  for (std::thread& thread : threads) thread.join();
  place = before;
  if (thrown) std::rethrow_exception(thrown);
}

template <class T>
class blocked_range {
 public:
  blocked_range(T begin, T end, std::size_t grain = 1) : begin_(begin), end_(end), grain_(grain) {}
  T begin() const { return begin_; }
  T end() const { return end_; }
  std::size_t size() const { return begin_ < end_ ? std::size_t(end_ - begin_) : 0; }
  std::size_t grain() const { return grain_; }

 private:
  T begin_, end_;
  std::size_t grain_;
};
template <class T>
class blocked_range2d {
 public:
  blocked_range2d(T row_begin, T row_end, T column_begin, T column_end)
      : rows_(row_begin, row_end), columns_(column_begin, column_end) {}
  blocked_range2d(const blocked_range<T>& rows, const blocked_range<T>& columns)
      : rows_(rows), columns_(columns) {}
  const blocked_range<T>& rows() const { return rows_; }
  const blocked_range<T>& cols() const { return columns_; }

 private:
  blocked_range<T> rows_, columns_;
};
struct simple_partitioner {};

// Calls body(range) for the parts of a range, and returns how many there are.
template <class T, class Body>
std::size_t ForEachPart(const blocked_range<T>& range, const Body& body) {
  const std::size_t grain = std::max(range.grain(), range.size() / 64);
  const std::size_t parts = (range.size() + grain - 1) / grain;
  ForEachPiece(parts, [&](std::size_t i) {
    const std::size_t end = std::min((i + 1) * grain, range.size());
    body(i, blocked_range<T>(range.begin() + T(i * grain), range.begin() + T(end)));
  });
  return parts;
}

template <class T, class Body>
void parallel_for(const blocked_range<T>& range, const Body& body) {
  ForEachPart(range, [&](std::size_t, const blocked_range<T>& part) { body(part); });
}
template <class T, class Body>
void parallel_for(const blocked_range<T>& range, const Body& body, simple_partitioner) {
  parallel_for(range, body);
}
template <class T, class Body>
void parallel_for(const blocked_range2d<T>& range, const Body& body) {
  parallel_for(range.rows(),
               [&](const blocked_range<T>& rows) { body(blocked_range2d<T>(rows, range.cols())); });
}
template <class T, class Body>
requires std::is_integral_v<T>
void parallel_for(T begin, T end, const Body& body) {
  parallel_for(blocked_range<T>(begin, end), [&](const blocked_range<T>& part) {
    for (T i = part.begin(); i != part.end(); ++i) body(i);
  });
}

template <class T, class Value, class Body, class Join>
Value parallel_reduce(const blocked_range<T>& range, const Value& identity, const Body& body,
                      const Join& join) {
  std::vector<Value> values(range.size(), identity);
  values.resize(
      ForEachPart(range, [&](std::size_t i,
                             const blocked_range<T>& part) { values[i] = body(part, identity); }),
      identity);
  Value all = identity;
  for (const Value& value : values) all = join(all, value);
  return all;
}

template <class... Work>
void parallel_invoke(const Work&... work) {
  const std::function<void()> each[] = {work...};
  ForEachPiece(sizeof...(work), [&](std::size_t i) { each[i](); });
}

template <class Iterator, class... Less>
void parallel_sort(Iterator begin, Iterator end, const Less&... less) {
  std::sort(begin, end, less...);
}

template <class T>
class enumerable_thread_specific {
 public:
  T& local() {
    const std::lock_guard lock(mutex_);
    return values_[std::this_thread::get_id()];
  }

 private:
  std::mutex mutex_;
  std::map<std::thread::id, T> values_;
};

// One item after the other goes through all filters.
enum class filter_mode { parallel, serial_in_order };
class flow_control {
 public:
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  bool stopped_ = false;
};
template <class In, class Out>
struct filter {
  using Argument = std::conditional_t<std::is_void_v<In>, flow_control&, In>;
  std::function<Out(Argument, flow_control&)> run;
};
template <class In, class Out, class F>
filter<In, Out> make_filter(filter_mode, const F& f) {
  using Argument = typename filter<In, Out>::Argument;
  return {[f](Argument in, flow_control&) -> Out { return f(in); }};
}
template <class In, class Middle, class Out>
filter<In, Out> operator&(const filter<In, Middle>& a, const filter<Middle, Out>& b) {
  using Argument = typename filter<In, Out>::Argument;
  return {[a, b](Argument in, flow_control& control) -> Out {
    Middle middle = a.run(in, control);
    if (control.stopped()) return Out();
    return b.run(std::move(middle), control);
  }};
}
inline void parallel_pipeline(std::size_t, const filter<void, void>& all) {
  for (flow_control control; !control.stopped();) all.run(control, control);
}

class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter, std::size_t) {}
};

}  // namespace tbb
