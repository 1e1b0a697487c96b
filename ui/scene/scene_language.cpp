#include "ui/scene/scene_language.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace retractor::ui {

namespace {

    /// A part of a text that stays on one line.
    struct Word {
        std::string text;
        std::size_t columns = 0;
        bool blank_before = false;
    };

    /// Bytes of the letter that begins with this byte in UTF-8.
    std::size_t letter_bytes(char first)
    {
        const auto byte = static_cast<unsigned char>(first);
        return byte < 0x80U ? 1 : byte < 0xE0U ? 2 : byte < 0xF0U ? 3 : 4;
    }

    /// Letters of three bytes and more begin at U+0800. From U+2E80 on they are Chinese, Japanese or Korean.
    bool is_wide(std::string_view letter) { return letter.size() >= 3 && letter >= "\u2E80"; }

    bool ends_a_clause(std::string_view letter)
    {
        constexpr std::array<std::string_view, 8> kMarks { "、", "。", "）", "」", "：", "；", "・", "ー" };
        return std::ranges::find(kMarks, letter) != kMarks.end();
    }

    std::vector<Word> words_of(std::string_view text)
    {
        std::vector<Word> words;
        bool begins = true, blank = false, after_wide = false;
        while (!text.empty()) {
            const std::string_view letter = text.substr(0, letter_bytes(text.front()));
            text.remove_prefix(letter.size());
            if (letter == " ") {
                blank = begins = true;
                continue;
            }
            const bool wide = is_wide(letter);
            const bool stays = !blank && !words.empty() && ends_a_clause(letter);
            if ((begins || wide || after_wide) && !stays)
                words.push_back({ .text = {}, .blank_before = blank && !words.empty() });
            words.back().text += letter;
            words.back().columns += wide ? 2 : 1;
            after_wide = wide;
            begins = blank = false;
        }
        return words;
    }

} // namespace

std::string said(const TextLanguage& language, const std::string& english)
{
    return language ? language(english) : english;
}

void say_texts(Scene& scene, const TextLanguage& language)
{
    if (!language)
        return;
    scene.title = language(scene.title);
    for (LegendLine& line : scene.legend) {
        line.key = language(line.key);
        line.value = language(line.value);
    }
    for (std::string& note : scene.notes)
        note = language(note);
    for (TextItem& word : scene.words)
        word.text = language(word.text);
}

std::vector<std::string> in_lines(const std::string& text, std::size_t columns)
{
    std::vector<std::string> lines;
    std::size_t used = 0;
    for (const Word& word : words_of(text)) {
        const std::size_t blank = word.blank_before ? 1 : 0;
        if (lines.empty() || used + blank + word.columns > columns) {
            lines.push_back(word.text);
            used = word.columns;
        } else {
            lines.back() += (word.blank_before ? " " : "") + word.text;
            used += blank + word.columns;
        }
    }
    return lines;
}

} // namespace retractor::ui
