#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace lightgrid {

/// Answers one question at a time beside the frame loop, always the latest; nothing of what was asked before comes any
/// more. News of an answer may come in parts.
template <class Question, class News>
class BackgroundAnswer {
  public:
    /// One question, to the one who answers it.
    class Turn {
      public:
        /// Throws, to end the work, where something else was asked since, or all is to end.
        void check() const {
            const std::lock_guard lock(owner_.mutex_);
            if (stop_.stop_requested() || owner_.number_ != number_) throw Over();
        }
        /// Calls change(what there is to be taken), unless something else was asked since.
        template <class Change>
        void tell(Change change) const {
            const std::lock_guard lock(owner_.mutex_);
            if (owner_.number_ == number_) change(owner_.news_);
        }

      private:
        friend BackgroundAnswer;
        Turn(BackgroundAnswer& owner, const std::stop_token& stop, std::uint64_t number)
            : owner_(owner), stop_(stop), number_(number) {}

        BackgroundAnswer& owner_;
        const std::stop_token& stop_;
        std::uint64_t number_;
    };

    /// answer  called from another thread, one question after the other
    explicit BackgroundAnswer(std::function<void(const Question&, const Turn&)> answer)
        : thread_([this, answer = std::move(answer)](const std::stop_token& stop) { work(stop, answer); }) {}
    /// Stops at the next Turn::check, and waits for it (as a jthread does).
    ~BackgroundAnswer() = default;
    BackgroundAnswer(const BackgroundAnswer&) = delete;
    BackgroundAnswer& operator=(const BackgroundAnswer&) = delete;

    /// Does not wait.
    void ask(Question question) {
        {
            const std::lock_guard lock(mutex_);
            question_ = std::move(question);
            ++number_;
            news_.reset();
            failure_ = nullptr;
        }
        asked_.notify_one();
    }

    /// What has come since it was last taken. Throws, once, what answering threw. Never waits for an answer.
    [[nodiscard]] std::optional<News> take() {
        const std::lock_guard lock(mutex_);
        if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
        return std::exchange(news_, std::nullopt);
    }

  private:
    struct Over {};

    void work(const std::stop_token& stop, const std::function<void(const Question&, const Turn&)>& answer) {
        std::uint64_t answered = 0;
        while (true) {
            Question question;
            {
                std::unique_lock lock(mutex_);
                if (!asked_.wait(lock, stop, [&] { return number_ != answered; })) return;
                question = question_;
                answered = number_;
            }
            const Turn turn(*this, stop, answered);
            try {
                answer(question, turn);
            } catch (const Over&) {  // as asked
            } catch (...) {
                turn.tell([&](std::optional<News>&) { failure_ = std::current_exception(); });
            }
        }
    }

    std::mutex mutex_;  // of all below; held for a move at most
    std::condition_variable_any asked_;
    Question question_{};
    std::uint64_t number_ = 0;  // of the latest question; 0: none yet
    std::optional<News> news_;
    std::exception_ptr failure_;
    std::jthread thread_;  // last: the others must be there while it runs
};

}  // namespace lightgrid
