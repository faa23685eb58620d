#pragma once
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

namespace firn {

/// Hands items from one thread to another, in order; whoever is ahead waits.
template <class T> class Queue {
public:
    explicit Queue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits for room. False if the queue was closed or cancelled: the item is then gone.
    bool push(T&& item) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || items_.size() < capacity_; });
        if (closed_) return false;
        items_.push_back(std::move(item));
        changed_.notify_all();
        return true;
    }

    /// Waits for an item; none once the queue is closed and empty.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || !items_.empty(); });
        if (items_.empty()) return {};
        std::optional<T> item = std::move(items_.front());
        items_.pop_front();
        changed_.notify_all();
        return item;
    }

    /// No more items will come; those that are in it are still handed out.
    void close() { finish(false); }

    /// As close, and drops what is in it.
    void cancel() { finish(true); }

private:
    void finish(bool drop) {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        if (drop) items_.clear();
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> items_;
    std::size_t capacity_;
    bool closed_ = false;
};

}  // namespace firn
