/* See equations_fit.h. The same in Python is equations_fit.py of urdf2mbs.
 *
 * Equations rely on the tree of joints, on which numbers are zero, and on the positions of joints
 * that never move. These are described as text, a line for each element, and the checksum of this
 * text is compared with the one in the head of each file of equations. CMakeLists.txt takes these
 * heads when it builds the program, and writes them into equations_of_build.h:
 *
 *     the .mbs -> elements -> description -> sha256  == ?  Fits (tree, fixed): sha256 ...
 *
 * Without this header the equations cannot be compared, and fit. */
#include "equations_fit.h"

#ifndef WITH_EQUATIONS_OF_BUILD

int check_equations(const char *mbs_file)
{
    (void) mbs_file;
    return 1;
}

#else

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the head of a file of equations says of the models that it fits. */
typedef struct EquationsHead {
    const char *file, *parts, *checksum;
} EquationsHead;

/* Defines HAS_EQUATIONS (0 or 1) and EQUATIONS_HEADS; BUILD_FOLDER is CMake's. */
#include "equations_of_build.h"

static const EquationsHead heads[] = { EQUATIONS_HEADS { NULL, NULL, NULL } };

/* A number this many times smaller than the largest beside it is a rounding of zero. */
#define ROUNDING 1e-15

/* --- sha256: the names are those of FIPS 180-4, section 6.2 --- */

typedef struct Sha256 {
    uint32_t H[8];
    unsigned char block[64];
    uint64_t n_bytes;
} Sha256;

static const uint32_t K[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
};

static uint32_t rotate_right(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

static void hash_block(Sha256 *sha)
{
    uint32_t W[64], s[8];

    for (int t = 0; t < 16; t++) {
        const unsigned char *word = sha->block + 4 * t;
        W[t] = 0;
        for (int k = 0; k < 4; k++) {
            W[t] = W[t] << 8 | word[k];
        }
    }
    for (int t = 16; t < 64; t++) {
        uint32_t x = W[t - 15], y = W[t - 2];
        uint32_t sigma0 = rotate_right(x, 7) ^ rotate_right(x, 18) ^ x >> 3;
        uint32_t sigma1 = rotate_right(y, 17) ^ rotate_right(y, 19) ^ y >> 10;
        W[t] = sigma1 + W[t - 7] + sigma0 + W[t - 16];
    }
    memcpy(s, sha->H, sizeof s); /* a, b, ..., h */
    for (int t = 0; t < 64; t++) {
        uint32_t a = s[0], e = s[4];
        uint32_t Sigma1 = rotate_right(e, 6) ^ rotate_right(e, 11) ^ rotate_right(e, 25);
        uint32_t Sigma0 = rotate_right(a, 2) ^ rotate_right(a, 13) ^ rotate_right(a, 22);
        uint32_t Ch = (e & s[5]) ^ (~e & s[6]);
        uint32_t Maj = (a & s[1]) ^ (a & s[2]) ^ (s[1] & s[2]);
        uint32_t T1 = s[7] + Sigma1 + Ch + K[t] + W[t];
        memmove(s + 1, s, 7 * sizeof s[0]);
        s[4] += T1;
        s[0] = T1 + Sigma0 + Maj;
    }
    for (int k = 0; k < 8; k++) {
        sha->H[k] += s[k];
    }
}

static void start_hash(Sha256 *sha)
{
    static const uint32_t H0[8] = {
        0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19,
    };

    memcpy(sha->H, H0, sizeof H0);
    sha->n_bytes = 0;
}

static void hash_bytes(Sha256 *sha, const char *bytes, size_t length)
{
    for (size_t k = 0; k < length; k++) {
        sha->block[sha->n_bytes++ % 64] = (unsigned char) bytes[k];
        if (sha->n_bytes % 64 == 0) {
            hash_block(sha);
        }
    }
}

static void finish_hash(Sha256 *sha, char checksum[65])
{
    uint64_t n_bits = 8 * sha->n_bytes;

    hash_bytes(sha, "\x80", 1);
    while (sha->n_bytes % 64 != 56) {
        hash_bytes(sha, "", 1);
    }
    for (int k = 7; k >= 0; k--) {
        char byte = (char) (n_bits >> 8 * k & 0xff);
        hash_bytes(sha, &byte, 1);
    }
    for (int k = 0; k < 8; k++) {
        snprintf(checksum + 8 * k, 9, "%08lx", (unsigned long) sha->H[k]);
    }
}

/* --- the elements of an .mbs --- */

typedef struct Text {
    const char *start;
    size_t length;
} Text;

/* Elements are numbered in the order of the file; -1 is none. */
typedef struct Element {
    Text tag, attributes, text;
    int parent, first_child, last_child, next;
} Element;

typedef struct Document {
    char *bytes;
    Element *elements;
    int n_elements;
} Document;

static void *allocate(void *memory, size_t size)
{
    void *larger = realloc(memory, size);

    if (larger == NULL) {
        fprintf(stderr, "error: out of memory\n");
        exit(EXIT_FAILURE);
    }
    return larger;
}

static int is_blank(char letter)
{
    return letter != '\0' && strchr(" \t\r\n", letter) != NULL;
}

static Text strip(const char *start, const char *end)
{
    while (start < end && is_blank(*start)) {
        start++;
    }
    while (start < end && is_blank(end[-1])) {
        end--;
    }
    return (Text) { start, (size_t) (end - start) };
}

/* Where the markup ends that begins at a '<': behind its '>', or at the end of the file. */
static const char *end_of_markup(const char *cursor)
{
    const char *closing = NULL;
    char quote = '\0';

    if (strncmp(cursor, "<!--", 4) == 0) {
        closing = "-->";
    } else if (strncmp(cursor, "<?", 2) == 0) {
        closing = "?>";
    }
    if (closing != NULL) {
        const char *end = strstr(cursor, closing);
        return end == NULL ? cursor + strlen(cursor) : end + strlen(closing);
    }
    for (; *cursor != '\0'; cursor++) {
        if (quote != '\0') {
            quote = *cursor == quote ? '\0' : quote;
        } else if (*cursor == '"' || *cursor == '\'') {
            quote = *cursor;
        } else if (*cursor == '>') {
            return cursor + 1;
        }
    }
    return cursor;
}

static int append_element(Document *document, int parent, Text tag, Text attributes, Text text)
{
    int number = document->n_elements++;
    Element *elements;

    if ((number & (number - 1)) == 0) { /* a power of two: double the room */
        size_t room = number == 0 ? 1 : 2 * (size_t) number;
        document->elements = allocate(document->elements, room * sizeof(Element));
    }
    elements = document->elements;
    elements[number] = (Element) { tag, attributes, text, parent, -1, -1, -1 };
    if (parent >= 0) {
        if (elements[parent].first_child < 0) {
            elements[parent].first_child = number;
        } else {
            elements[elements[parent].last_child].next = number;
        }
        elements[parent].last_child = number;
    }
    return number;
}

static void find_elements(Document *document)
{
    int parent = -1;
    const char *cursor = strchr(document->bytes, '<');

    while (cursor != NULL) {
        const char *end = end_of_markup(cursor);
        const char *next = strchr(end, '<');
        int is_tag = cursor[1] != '!' && cursor[1] != '?' && end > cursor + 2;

        if (is_tag && cursor[1] == '/') {
            parent = parent < 0 ? -1 : document->elements[parent].parent;
        } else if (is_tag) {
            int is_empty = end[-2] == '/';
            const char *inner = end - 1 - is_empty, *name = cursor + 1;
            size_t length = strcspn(name, " \t\r\n/>");
            Text attributes = strip(name + length, inner > name + length ? inner : name + length);
            Text text = strip(end, next == NULL ? end : next);
            Text tag = { name, length };
            int number = append_element(document, parent, tag, attributes, text);
            parent = is_empty ? parent : number;
        }
        cursor = next;
    }
}

/* 0 if the file cannot be read, or is no XML of one byte for each ASCII letter. */
static int read_document(Document *document, const char *file)
{
    FILE *stream = fopen(file, "rb");
    size_t length = 0, room = 1 << 16;

    *document = (Document) { NULL, NULL, 0 };
    if (stream == NULL) {
        return 0;
    }
    document->bytes = allocate(NULL, room);
    while (1) {
        length += fread(document->bytes + length, 1, room - 1 - length, stream);
        if (length < room - 1) {
            break;
        }
        room *= 2;
        document->bytes = allocate(document->bytes, room);
    }
    fclose(stream);
    document->bytes[length] = '\0';
    find_elements(document);
    return document->n_elements > 0;
}

static int equals(Text text, const char *word)
{
    return strlen(word) == text.length && memcmp(text.start, word, text.length) == 0;
}

static int are_equal(Text first, Text second)
{
    return first.length == second.length && memcmp(first.start, second.start, first.length) == 0;
}

/* The first child of this tag, or the next element of this tag beside one. */
static int find_child(const Document *document, int parent, const char *tag)
{
    int child = parent < 0 ? -1 : document->elements[parent].first_child;

    while (child >= 0 && !equals(document->elements[child].tag, tag)) {
        child = document->elements[child].next;
    }
    return child;
}

static int find_next(const Document *document, int element, const char *tag)
{
    do {
        element = document->elements[element].next;
    } while (element >= 0 && !equals(document->elements[element].tag, tag));
    return element;
}

static Text text_of(const Document *document, int element)
{
    return element < 0 ? (Text) { "", 0 } : document->elements[element].text;
}

static double number_of(const Document *document, int element)
{
    Text text = text_of(document, element);

    return text.length == 0 ? 0.0 : strtod(text.start, NULL);
}

static int has_attribute(Text attributes, const char *name)
{
    size_t length = strlen(name);
    const char *cursor = attributes.start, *end = cursor + attributes.length;
    char quote = '\0';

    for (; cursor < end; cursor++) {
        if (quote != '\0') {
            quote = *cursor == quote ? '\0' : quote;
        } else if (*cursor == '"' || *cursor == '\'') {
            quote = *cursor;
        } else {
            int is_start = cursor == attributes.start || strchr(" \t\r\n\"'", cursor[-1]) != NULL;
            int is_name = (size_t) (end - cursor) > length && strncmp(cursor, name, length) == 0;
            if (is_start && is_name && (cursor[length] == '=' || is_blank(cursor[length]))) {
                return 1;
            }
        }
    }
    return 0;
}

/* --- the description of a model: see describe() of equations_fit.py --- */

typedef struct Description {
    const Document *document;
    Sha256 sha;
    int tree, base; /* the elements <bodytree> and <base> */
    int exact, with_fixed;
} Description;

static const char *const AXES[] = { "x", "y", "z", NULL };
static const char *const INERTIA[] = { "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", NULL };
static const char *const MEASURES[] = { "Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac", NULL };
static const char *const SYMBOLS[] = { "q", "qd", "qdd", NULL };

static void add(Description *description, const char *word)
{
    hash_bytes(&description->sha, word, strlen(word));
}

static void add_text(Description *description, Text text)
{
    hash_bytes(&description->sha, text.start, text.length);
}

static void add_count(Description *description, int count)
{
    char digits[16];

    snprintf(digits, sizeof digits, "%d", count);
    add(description, digits);
}

static void add_double(Description *description, double value)
{
    char digits[40];

    snprintf(digits, sizeof digits, "%.17g", value + 0.0);
    add(description, digits);
}

/* The body of a name, counted from 0, and its element; -1 where there is none. */
static int find_body(const Description *description, Text name, int *element)
{
    const Document *document = description->document;
    int number = 0, last = -1;

    *element = -1;
    for (int body = find_child(document, description->tree, "body"); body >= 0;
            body = find_next(document, body, "body"), number++) {
        if (are_equal(text_of(document, find_child(document, body, "bodyname")), name)) {
            *element = body;
            last = number;
        }
    }
    return last;
}

/* The numbers of a body and of a point: names do not count. */
static void add_place(Description *description, int owner, const char *tag)
{
    const Document *document = description->document;
    int end = find_child(document, owner, tag), element, number = 0, point_number = 0, body;
    Text name = text_of(document, find_child(document, end, "bodyname"));
    Text point_name = text_of(document, find_child(document, end, "pointname"));

    body = find_body(description, name, &element);
    if (body >= 0) {
        add_count(description, body);
    } else {
        add_text(description, name);
        element = equals(name, "base") ? description->base : -1;
    }
    for (int point = find_child(document, element, "point"); point >= 0;
            point = find_next(document, point, "point")) {
        number++;
        if (are_equal(text_of(document, find_child(document, point, "pointname")), point_name)) {
            point_number = number;
        }
    }
    add(description, " ");
    add_count(description, point_number);
}

static void add_joint(Description *description, int joint)
{
    const Document *document = description->document;
    int symbols = find_child(document, joint, "symbols");
    int start = find_child(document, joint, "initialvalue");
    Text nature = text_of(document, find_child(document, joint, "nature"));
    int never_moves = symbols >= 0 && equals(nature, "driven");

    add(description, "joint ");
    add_text(description, text_of(document, find_child(document, joint, "type")));
    add(description, " ");
    add_text(description, nature);
    add(description, symbols < 0 ? " all" : " ");
    for (int k = 0; symbols >= 0 && SYMBOLS[k] != NULL; k++) {
        int is_present = find_child(document, symbols, SYMBOLS[k]) >= 0;
        never_moves = never_moves && is_present == (k == 0);
        if (is_present) {
            add(description, SYMBOLS[k]);
            add(description, ",");
        }
    }
    add(description, " ");
    add_double(description, never_moves && description->with_fixed
        ? number_of(document, find_child(document, start, "q")) : 0.0);
    add(description, "\n");
}

static void add_number(Description *description, int owner, const char *tag)
{
    double value = number_of(description->document, find_child(description->document, owner, tag));

    if (description->exact) {
        add_double(description, value);
    } else {
        add(description, value != 0.0 ? "1" : "0");
    }
}

/* The tags of the numbers in an element that are not zero, nor a rounding of it. */
static void add_numbers(Description *description, int element, const char *const tags[])
{
    double values[6], least = 0.0;

    for (int k = 0; tags[k] != NULL; k++) {
        values[k] = number_of(description->document,
            find_child(description->document, element, tags[k]));
        least = fmax(least, ROUNDING * fabs(values[k]));
    }
    for (int k = 0; tags[k] != NULL; k++) {
        if (fabs(values[k]) > least) {
            add(description, " ");
            add(description, tags[k]);
            if (description->exact) {
                add(description, "=");
                add_double(description, values[k]);
            }
        }
    }
    add(description, "\n");
}

static void add_point(Description *description, int point)
{
    const Document *document = description->document;

    add(description, "point");
    add_numbers(description, find_child(document, point, "coordinates"), AXES);
    for (int child = document->elements[point].first_child; child >= 0;
            child = document->elements[child].next) {
        const Element *measured = &document->elements[child];
        if (equals(measured->tag, "sensor") || equals(measured->tag, "extforce")) {
            add_text(description, measured->tag);
            for (int k = 0; MEASURES[k] != NULL; k++) {
                if (has_attribute(measured->attributes, MEASURES[k])) {
                    add(description, " ");
                    add(description, MEASURES[k]);
                }
            }
            add(description, "\n");
        }
    }
}

/* The base or a body. */
static void add_body(Description *description, int body)
{
    const Document *document = description->document;

    add(description, "body ");
    add_place(description, body, "parent");
    add(description, "\n");
    for (int joint = find_child(document, body, "joint"); joint >= 0;
            joint = find_next(document, joint, "joint")) {
        add_joint(description, joint);
    }
    add(description, "mass ");
    add_number(description, body, "mass");
    add(description, "\ncom");
    add_numbers(description,
        find_child(document, find_child(document, body, "com"), "coordinates"), AXES);
    add(description, "inertia");
    add_numbers(description, find_child(document, body, "inertia"), INERTIA);
    add(description, "gravity");
    add_numbers(description,
        find_child(document, find_child(document, body, "gravity"), "coordinates"), AXES);
    for (int point = find_child(document, body, "point"); point >= 0;
            point = find_next(document, point, "point")) {
        add_point(description, point);
    }
}

/* Cuts, or links. */
static void add_connections(Description *description, int list)
{
    const Document *document = description->document;

    for (int child = list < 0 ? -1 : document->elements[list].first_child; child >= 0;
            child = document->elements[child].next) {
        add_text(description, document->elements[child].tag);
        add(description, " ");
        add_place(description, child, "endpoint1");
        add(description, " ");
        add_place(description, child, "endpoint2");
        add(description, " ");
        add_number(description, child, "length");
        add(description, "\n");
    }
}

/* A checksum of what equations rely on; parts as in the head of their file. */
static void compute_fingerprint(const Document *document, const char *parts, char checksum[65])
{
    Description description = { .document = document };

    description.exact = strstr(parts, "numbers") != NULL;
    description.with_fixed = strcmp(parts, "tree") != 0;
    description.base = find_child(document, 0, "base");
    description.tree = find_child(document, 0, "bodytree");
    start_hash(&description.sha);
    add(&description, "model ");
    add_text(&description, text_of(document, find_child(document, 0, "mbsname")));
    add(&description, "\n");
    if (description.base >= 0) {
        add_body(&description, description.base);
    }
    for (int body = find_child(document, description.tree, "body"); body >= 0;
            body = find_next(document, body, "body")) {
        add_body(&description, body);
    }
    add_connections(&description, find_child(document, 0, "cuts"));
    add_connections(&description, find_child(document, 0, "links"));
    finish_hash(&description.sha, checksum);
}

int check_equations(const char *mbs_file)
{
    Document document;
    const char *first_stale = NULL;
    int n_stale = 0;

    if (HAS_EQUATIONS) {
        int is_read = read_document(&document, mbs_file); /* if not, mbs_load says so */
        for (const EquationsHead *head = heads; is_read && head->file != NULL; head++) {
            char checksum[65];
            compute_fingerprint(&document, head->parts, checksum);
            if (strcmp(checksum, head->checksum) != 0) {
                first_stale = first_stale == NULL ? head->file : first_stale;
                n_stale++;
            }
        }
        free(document.elements);
        free(document.bytes);
    }
    if (HAS_EQUATIONS && n_stale == 0) {
        return 1;
    }
    if (!HAS_EQUATIONS) {
        fprintf(stderr, "error: this program was built without equations of motion: symbolicR has"
            " no mbs_dirdyna");
    } else {
        fprintf(stderr, "error: this program was built with the equations of another model than %s:"
            " %s and %d more", mbs_file, first_stale, n_stale - 1);
    }
    fprintf(stderr, ". Make equations, then build again:\n"
        "    urdf2mbs equations \"%s\"\n    cmake --build \"%s\"\n", mbs_file, BUILD_FOLDER);
    return 0;
}

#endif
