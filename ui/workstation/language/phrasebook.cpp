#include "ui/workstation/language/phrasebook.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <QIODevice>
#include <QStringList>
#include <QXmlStreamReader>

#include <algorithm>
#include <optional>

namespace retractor::ui {

namespace {

    const QRegularExpression kPlace("%([1-9])");
    const QRegularExpression kWord("\\b[A-Za-z]{2,}"); // count() also counts matches that overlap
    /// A number, a name or a file stands in an open place; more words are a sentence that no phrase knows.
    constexpr int kMostWordsInAPlace = 6;
    constexpr int kMostWordsOfAName = 5; ///< in a list
    const QString kFullStop = QString::fromUtf8("\u3002");

    /// The phrase as a pattern; nothing in an open place ends a sentence or clause, so that a phrase does not swallow
    /// the next.
    OpenPhrase open_phrase(const QString& english, const QString& translation)
    {
        OpenPhrase phrase {
            .english = {}, .with_clauses = {}, .places = {}, .translation = translation, .source = english
        };
        QString pattern, with_clauses;
        int end = 0;
        for (auto found = kPlace.globalMatch(english); found.hasNext();) {
            const QRegularExpressionMatch place = found.next();
            const QString before = QRegularExpression::escape(english.mid(end, place.capturedStart() - end));
            pattern += before + "((?:(?![.;] ).)+?)";
            with_clauses += before + "((?:(?!\\. ).)+?)";
            phrase.places.push_back(place.captured(1).toInt());
            end = place.capturedEnd();
        }
        const QString behind = QRegularExpression::escape(english.mid(end));
        phrase.letters = english.size() - 2 * static_cast<int>(phrase.places.size());
        phrase.english = QRegularExpression(QRegularExpression::anchoredPattern(pattern + behind));
        phrase.with_clauses = QRegularExpression(QRegularExpression::anchoredPattern(with_clauses + behind));
        return phrase;
    }

    /// The translation of a phrase with open places; nothing where it is another phrase.
    /// @param pattern phrase.english or phrase.with_clauses
    std::optional<QString> filled(
        const Phrasebook& book, const QRegularExpression& pattern, const OpenPhrase& phrase, const QString& english)
    {
        const QRegularExpressionMatch match = pattern.match(english);
        if (!match.hasMatch())
            return std::nullopt;
        QString text;
        int end = 0;
        for (auto found = kPlace.globalMatch(phrase.translation); found.hasNext();) {
            const QRegularExpressionMatch place = found.next();
            text += phrase.translation.mid(end, place.capturedStart() - end);
            const auto capture = std::find(phrase.places.begin(), phrase.places.end(), place.captured(1).toInt());
            if (capture == phrase.places.end())
                return std::nullopt;
            const QString given = match.captured(1 + static_cast<int>(capture - phrase.places.begin()));
            const QString said = translated(book, given);
            if (said == given && given.count(kWord) > kMostWordsInAPlace)
                return std::nullopt;
            text += said;
            end = place.capturedEnd();
        }
        return text + phrase.translation.mid(end);
    }

    QString joined_parts(const Phrasebook& book, const QStringList& parts, const QString& between)
    {
        QStringList said;
        for (const QString& part : parts)
            said += translated(book, part);
        return said.join(between).replace("。 ", "。"); // in Japanese no space follows a sentence
    }

    /// The translation of a name; nothing where the book does not know all of it.
    std::optional<QString> translated_name(const Phrasebook& book, const QString& english)
    {
        if (const auto whole = book.phrases.find(english); whole != book.phrases.end())
            return *whole;
        for (const OpenPhrase& phrase : book.open_phrases) {
            const QStringList places = phrase.english.match(english).capturedTexts().mid(1);
            const auto is_known
                = [&](const QString& place) { return !place.contains(kWord) || book.phrases.contains(place); };
            if (!places.isEmpty() && std::all_of(places.begin(), places.end(), is_known))
                return filled(book, phrase.english, phrase, english);
        }
        return std::nullopt;
    }

    /// "27 to 33 mm", "3 of 4". @returns nothing where the text is not two such numbers, or their unit is a word
    std::optional<QString> translated_numbers(const QString& english)
    {
        static const QRegularExpression two_numbers(
            "^(-?[0-9][0-9.,]*) (to|of) (-?[0-9][0-9.,]*)( (?:mm|cm|cm2|N|N m|kPa|MPa|GPa|s|%))?$");
        const QRegularExpressionMatch match = two_numbers.match(english);
        if (!match.hasMatch())
            return std::nullopt;
        const QString between = match.captured(2) == "to" ? QString::fromUtf8(" \u301c ") : " / ";
        return match.captured(1) + between + match.captured(3) + match.captured(4);
    }

    /// The translation of a part of a list: a name with or without a number. @returns nothing where it is not known
    std::optional<QString> translated_part(const Phrasebook& book, const QString& english)
    {
        static const QRegularExpression number("(?: -?[0-9.]+ (?:mm|%|s)| \\([0-9.]+ %\\))$");
        const QString behind = number.match(english).captured();
        const QString name
            = QString::fromStdString(readable(english.left(english.size() - behind.size()).toStdString()));
        if (name.count(kWord) > kMostWordsOfAName || name.contains('%'))
            return std::nullopt;
        const std::optional<QString> said = translated_name(book, name);
        return said ? std::optional(*said + behind) : std::nullopt;
    }

    /// A list of names, each with a number or not: "heart 16.7 mm, aorta 18.7 mm", "skin (7 %) and fat (3 %)".
    /// @returns nothing where one of them is not known
    std::optional<QString> translated_list(const Phrasebook& book, const QString& english)
    {
        static const QString last_between(" and ");
        static const QRegularExpression number_or_id("[0-9_]");
        QStringList parts = english.split(", "), said;
        const bool is_one_name
            = parts.size() == 1 && !english.contains(number_or_id) && !english.contains(last_between);
        if (is_one_name || english.contains("; ") || english.contains(". "))
            return std::nullopt;
        const QString last = parts.takeLast();
        for (const QString& part : parts) {
            const std::optional<QString> one = translated_part(book, part);
            if (!one)
                return std::nullopt;
            said += *one;
        }
        std::optional<QString> end = translated_part(book, last);
        for (int at = last.indexOf(last_between); at > 0 && !end; at = last.indexOf(last_between, at + 1)) {
            const auto before = translated_part(book, last.left(at)),
                       behind = translated_part(book, last.mid(at + last_between.size()));
            if (before && behind)
                end = *before + QString::fromUtf8("\u3001") + *behind;
        }
        return end ? std::optional((said << *end).join(QString::fromUtf8("\u3001"))) : std::nullopt;
    }

    /// A phrase whose places hold several clauses, as reasons do that are joined.
    std::optional<QString> filled_with_clauses(const Phrasebook& book, const QString& english)
    {
        constexpr int kFewestLetters = 12; // less says too little of what stands in its places
        for (const OpenPhrase& phrase : book.open_phrases)
            if (phrase.letters >= kFewestLetters)
                if (const auto text = filled(book, phrase.with_clauses, phrase, english))
                    return text;
        return std::nullopt;
    }

    /// A sentence of several clauses: "opened by half a turn; held for 5 minutes." @returns nothing where none is known
    std::optional<QString> translated_clauses(const Phrasebook& book, QString english)
    {
        if (!english.contains("; "))
            return std::nullopt;
        const bool ends = english.endsWith('.');
        const QString whole = english;
        if (ends)
            english.chop(1);
        const QStringList clauses = english.split("; ");
        QStringList said;
        int known = 0;
        for (const QString& clause : clauses) {
            said += translated(book, clause);
            known += said.back() != clause;
        }
        if (known < clauses.size())
            if (const auto text = filled_with_clauses(book, whole))
                return text;
        if (known == 0)
            return std::nullopt;
        return said.join(QString::fromUtf8("\uff1b")) + (ends ? kFullStop : QString());
    }

    /// A phrase that the book knows without its full stop.
    std::optional<QString> translated_without_stop(const Phrasebook& book, QString english)
    {
        if (!english.endsWith('.') || english.endsWith(".."))
            return std::nullopt;
        english.chop(1);
        const QString said = translated(book, english);
        return said == english ? std::nullopt : std::optional(said + kFullStop);
    }

} // namespace

Phrasebook read_phrasebook(QIODevice& file)
{
    Phrasebook book;
    QXmlStreamReader xml(&file);
    QString source;
    while (!xml.atEnd()) {
        xml.readNext();
        if (!xml.isStartElement())
            continue;
        if (xml.name() == QLatin1String("source"))
            source = xml.readElementText();
        else if (xml.name() == QLatin1String("translation")) {
            const QString translation = xml.readElementText();
            if (translation.isEmpty()) // not yet translated
                continue;
            if (source.contains(kPlace))
                book.open_phrases.push_back(open_phrase(source, translation));
            else
                book.phrases.insert(source, translation);
        }
    }
    if (xml.hasError())
        throw InputError(xml.errorString().toStdString(), "line " + std::to_string(xml.lineNumber()));
    std::stable_sort(book.open_phrases.begin(), book.open_phrases.end(),
        [](const OpenPhrase& a, const OpenPhrase& b) { return a.letters > b.letters; });
    return book;
}

QString translated(const Phrasebook& book, const QString& english)
{
    if (const auto whole = book.phrases.find(english); whole != book.phrases.end())
        return *whole;
    if (!english.contains(kWord)) // a number
        return english;
    if (english.contains('\n'))
        return joined_parts(book, english.split('\n'), "\n");
    if (const auto numbers = translated_numbers(english))
        return *numbers;
    if (const auto list = translated_list(book, english)) // before a phrase takes two names for one
        return *list;
    for (const OpenPhrase& phrase : book.open_phrases)
        if (const auto text = filled(book, phrase.english, phrase, english))
            return *text;
    QStringList sentences;
    int begin = 0;
    for (int end = english.indexOf(". "); end >= 0; end = english.indexOf(". ", begin)) {
        sentences += english.mid(begin, end + 1 - begin);
        begin = end + 2;
    }
    if (sentences.isEmpty()) {
        if (const auto clauses = translated_clauses(book, english))
            return *clauses;
        return translated_without_stop(book, english).value_or(english);
    }
    sentences += english.mid(begin);
    return joined_parts(book, sentences, " ");
}

} // namespace retractor::ui
