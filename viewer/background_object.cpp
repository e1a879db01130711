#include "viewer/background_object.h"

#include "viewer/transfer.h"

#include <utility>

namespace lightgrid {
namespace {

/// Thrown through the tracing to end it.
struct Stopped {};

}  // namespace

BackgroundObject::BackgroundObject() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

BackgroundObject::~BackgroundObject() = default;  // a jthread asks to stop, and waits

void BackgroundObject::ask(Load load) {
    {
        const std::lock_guard lock(mutex_);
        question_ = {std::move(load), question_.number + 1};
        news_.reset();
        failure_ = nullptr;
    }
    asked_.notify_one();
}

std::optional<ObjectNews> BackgroundObject::take() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::exchange(news_, std::nullopt);
}

void BackgroundObject::work(const std::stop_token& stop) {
    std::uint64_t answered = 0;
    while (true) {
        Question question;
        {
            std::unique_lock lock(mutex_);
            if (!asked_.wait(lock, stop, [&] { return question_.number != answered; })) return;
            question = question_;
        }
        answered = question.number;
        try {
            answer(stop, question);
        } catch (const Stopped&) {  // as asked
        } catch (...) {
            tell(question, [&] { failure_ = std::current_exception(); });
        }
    }
}

void BackgroundObject::tell(const Question& question, const std::function<void()>& change) {
    const std::lock_guard lock(mutex_);
    if (question_.number == question.number) change();
}

void BackgroundObject::answer(const std::stop_token& stop, const Question& question) {
    const ObjectMesh mesh = question.load();
    ObjectMesh shown = mesh;
    tell(question, [&] { news_ = ObjectNews{std::move(shown), {}}; });
    TransferOptions options = shown_transfer(mesh);
    options.step = [&] {
        const std::lock_guard lock(mutex_);
        if (stop.stop_requested() || question_.number != question.number) throw Stopped();
    };
    std::vector<float> transfer = self_shadowed_transfer(mesh, options);
    tell(question, [&] {
        if (!news_) news_.emplace();
        news_->transfer = std::move(transfer);
    });
}

}  // namespace lightgrid
