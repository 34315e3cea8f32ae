/* See equations_fit.h. In Python, equations_fit.py of urdf2mbs does the same.
 *
 * Equations rely on the tree of joints, on which numbers are zero, and on the positions of joints
 * that never move. These are described as text, a line for each element, and the checksum of this
 * text is compared with the one in the head of each file of equations. CMakeLists.txt takes these
 * heads when it builds the program, and writes them into equations_of_build.h:
 *
 *     the .mbs -> elements -> description -> sha256  == ?  Fits (tree, fixed): sha256 ...
 *
 * Without this header the equations cannot be compared, and are assumed to fit. */
#include "equations_fit.h"

#ifndef WITH_EQUATIONS_OF_BUILD

int check_equations(const char *mbs_file)
{
    (void) mbs_file;
    return 1;
}

#else

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "equations_fit_elements.h"
#include "equations_fit_sha256.h"

/* The line in the head of a file of equations that states which models it fits. */
typedef struct EquationsHead {
    const char *file, *parts, *checksum;
} EquationsHead;

/* Defines HAS_EQUATIONS (0 or 1) and EQUATIONS_HEADS; BUILD_FOLDER is CMake's. */
#include "equations_of_build.h"

static const EquationsHead heads[] = { EQUATIONS_HEADS { NULL, NULL, NULL } };

/* A number this many times smaller than the largest beside it is a rounding of zero. */
#define ROUNDING 1e-15

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

/* Return the number of the body of a name, counted from 0, and its element; -1 if there is none. */
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

/* Add the numbers of a body and of a point, not their names. */
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

/* Add the tags of the numbers in an element that are neither zero nor a rounding of zero. */
static void add_numbers(Description *description, int element, const char *const tags[])
{
    double values[6], threshold = 0.0;

    for (int k = 0; tags[k] != NULL; k++) {
        values[k] = number_of(description->document,
            find_child(description->document, element, tags[k]));
        threshold = fmax(threshold, ROUNDING * fabs(values[k]));
    }
    for (int k = 0; tags[k] != NULL; k++) {
        if (fabs(values[k]) > threshold) {
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

/* Add the base or a body. */
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

/* Add the cuts, or the links. */
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

/* Compute the checksum of a model; parts as in the head of a file of equations. */
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
