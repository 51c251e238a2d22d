/* The minimum distance between two surfaces of triangles, and whether they come nearer than a margin: what
   ../triangle_pairs.py does, with the trees of ../box_tree.py.

   Pairs are examined in the same order, with the same operations, so both forms give the same numbers bit for bit: no sum
   is reordered, and the build forbids fused multiplications (-ffp-contract=off). A formula that changes here changes
   there; tests/server/sensors/test_compiled_distances.py holds both equal. Only work that cannot change the result is
   left out here: bounds are computed no further than they are needed, and pairs that are surely farther apart than the
   best one of their batch.

   `possible_pairs` does what `GeomPairs` in ../meeting.py does: it leaves out pairs of geoms by balls and boxes around them.

   The interpreter's lock is released during a search: it reads nothing but arrays that never change. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* as in ../box_tree.py and ../triangle_pairs.py */
#define FAN 8
#define BOXES_AT_ONCE 32
#define PAIRS_AT_ONCE 512
#define ROUNDING 1e-9
#define SMALLEST 1e-12
#define APART 1e-6
#define MUCH (1.0 - 1e-6)
#define PARALLEL 1e-14

#define MOST_LEVELS 12 /* enough for all numbers of triangles that an int32_t counts */
#define MOST_CHILDREN (BOXES_AT_ONCE * FAN * FAN)

typedef const double* Vector; /* three numbers */


//------------------------------------------ arithmetic --------------------------------------------

static double dot(Vector a, Vector b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void subtract(double* found, Vector a, Vector b) {
  for (int i = 0; i < 3; i++) {
    found[i] = a[i] - b[i];
  }
}

static void cross(double* found, Vector a, Vector b) {
  found[0] = a[1] * b[2] - a[2] * b[1];
  found[1] = a[2] * b[0] - a[0] * b[2];
  found[2] = a[0] * b[1] - a[1] * b[0];
}

/* A row times a matrix (3, 3), as `turned`; and the same with the matrix transposed. */
static void turn(double* found, Vector v, const double* m) {
  for (int i = 0; i < 3; i++) {
    found[i] = v[0] * m[i] + v[1] * m[3 + i] + v[2] * m[6 + i];
  }
}

static void turn_back(double* found, Vector v, const double* m) {
  for (int i = 0; i < 3; i++) {
    found[i] = v[0] * m[3 * i] + v[1] * m[3 * i + 1] + v[2] * m[3 * i + 2];
  }
}

/* np.maximum, np.clip with 0 and 1: nan wins */
static double maximum(double a, double b) { return (a > b || isnan(a)) ? a : b; }
static double clip(double x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

/* `_beyond` */
static double beyond(double distance) { return distance * (1.0 + ROUNDING) + SMALLEST; }


//------------------------------------------ trees -------------------------------------------------

typedef struct {
  const double *corners, *boxes, *turn, *place;
  Py_ssize_t count; /* of triangles */
  int levels;
  Py_ssize_t starts[MOST_LEVELS], sizes[MOST_LEVELS]; /* of the levels among the boxes */

  /* How far the triangles of a box extend: the greatest coordinate along a direction, or the smallest. */
  int is_second;
  double direction[3]; /* in the geom's frame */
  double* ends;
  int32_t* known_since; /* the number of the direction for which an end was computed */
} Surface;

typedef struct {
  double bound;
  int32_t order, mine, theirs;
} Pair;

typedef struct {
  double distance;
  double first[3], second[3];
  int32_t mine, theirs; /* -1: none */
} Gap;

typedef struct {
  Surface first, second;
  double turn[9], place[3], spread[9]; /* of the second in the frame of the first */
  double shift;
  int32_t direction; /* its number */
  Gap best;
  Pair* pairs[MOST_LEVELS];
  Pair batch[PAIRS_AT_ONCE];
} Search;

static const double* box_of(const Surface* s, int level, int32_t box) {
  int at = level < s->levels ? level : s->levels - 1;
  return s->boxes + 6 * (s->starts[at] + box);
}

static double end_of(Surface* s, int level, Py_ssize_t box, int32_t direction) {
  Py_ssize_t at = s->starts[level] + box;
  if (s->known_since[at] == direction) {
    return s->ends[at];
  }
  double end;
  if (level == 0) {
    const double* corners = s->corners + 9 * box;
    end = dot(corners, s->direction);
    for (int i = 1; i < 3; i++) {
      double other = dot(corners + 3 * i, s->direction);
      end = (s->is_second ? other < end : other > end) ? other : end;
    }
  } else {
    Py_ssize_t child = box * FAN, stop = child + FAN;
    stop = stop < s->sizes[level - 1] ? stop : s->sizes[level - 1];
    end = end_of(s, level - 1, child, direction);
    for (child++; child < stop; child++) {
      double other = end_of(s, level - 1, child, direction);
      end = (s->is_second ? other < end : other > end) ? other : end;
    }
  }
  s->known_since[at] = direction;
  return s->ends[at] = end;
}

/* `Placed.middle` */
static void middle_of(const Surface* s, double* found) {
  Py_ssize_t count = s->sizes[s->levels - 1];
  const double* boxes = s->boxes + 6 * s->starts[s->levels - 1];
  double centre[3] = {boxes[0], boxes[1], boxes[2]};
  for (Py_ssize_t box = 1; box < count; box++) {
    for (int i = 0; i < 3; i++) {
      centre[i] += boxes[6 * box + i];
    }
  }
  for (int i = 0; i < 3; i++) {
    centre[i] /= (double)count;
  }
  turn_back(found, centre, s->turn);
  for (int i = 0; i < 3; i++) {
    found[i] += s->place[i];
  }
}

/* The corners of a triangle in the world. */
static void corners_of(const Surface* s, int32_t triangle, double* found) {
  for (int i = 0; i < 3; i++) {
    turn_back(found + 3 * i, s->corners + 9 * (Py_ssize_t)triangle + 3 * i, s->turn);
    for (int j = 0; j < 3; j++) {
      found[3 * i + j] += s->place[j];
    }
  }
}


//------------------------------------------ bounds ------------------------------------------------

/* `Bounds.look_along` */
static void look_along(Search* s, Vector towards) {
  double direction[3], away[3], length = sqrt(dot(towards, towards));
  length = length > 1e-300 ? length : 1e-300;
  for (int i = 0; i < 3; i++) {
    direction[i] = towards[i] / length;
  }
  turn(s->first.direction, direction, s->first.turn);
  turn(s->second.direction, direction, s->second.turn);
  subtract(away, s->second.place, s->first.place);
  s->shift = dot(direction, away);
  s->direction++;
}

static double square(const double* gaps) {
  double positive[3];
  for (int i = 0; i < 3; i++) {
    positive[i] = maximum(gaps[i], 0.0);
  }
  return dot(positive, positive);
}

/* `Bounds.between`, no further than up to a bound above `most`. */
static double bound_of(Search* s, int level, int32_t mine, int32_t theirs, double most) {
  const double *ours = box_of(&s->first, level, mine), *yours = box_of(&s->second, level, theirs);
  double away[3], other[3], reach[3];
  turn_back(away, yours, s->turn);
  turn_back(reach, yours + 3, s->spread);
  double along[3];
  for (int i = 0; i < 3; i++) {
    away[i] = away[i] + s->place[i] - ours[i];
    along[i] = fabs(away[i]) - ours[3 + i] - reach[i];
  }
  turn(other, away, s->turn);
  turn(reach, ours + 3, s->spread);
  for (int i = 0; i < 3; i++) {
    other[i] = fabs(other[i]) - yours[3 + i] - reach[i];
  }
  double by_sides = sqrt(maximum(square(along), square(other)));
  if (by_sides > most) {
    return by_sides;
  }
  int top = s->first.levels - 1, other_top = s->second.levels - 1;
  double end = end_of(&s->first, level < top ? level : top, mine, s->direction);
  double begin = end_of(&s->second, level < other_top ? level : other_top, theirs, s->direction);
  return maximum(by_sides, begin - end + s->shift);
}


//------------------------------------------ two triangles -----------------------------------------

/* Whether a point of a triangle's plane lies within it: `_held`. */
static int is_held(Vector point, const double* face, Vector normal) {
  for (int i = 0; i < 3; i++) {
    double side[3], inward[3], offset[3];
    subtract(side, face + 3 * ((i + 1) % 3), face + 3 * i);
    cross(inward, normal, side);
    subtract(offset, point, face + 3 * i);
    if (!(dot(offset, inward) >= 0.0)) {
      return 0;
    }
  }
  return 1;
}

static void normal_of(double* normal, const double* face) {
  double side[3], other[3];
  subtract(side, face + 3, face);
  subtract(other, face + 6, face);
  cross(normal, side, other);
}

static void heights_of(double* heights, const double* corners, const double* face, Vector normal) {
  for (int i = 0; i < 3; i++) {
    double offset[3];
    subtract(offset, corners + 3 * i, face);
    heights[i] = dot(offset, normal);
  }
}

/* Whether an edge passes through the other triangle, and the point where the first such edge does: `_pierced`. */
static int is_pierced(const double* corners, const double* face, double* point) {
  double normal[3], heights[3];
  normal_of(normal, face);
  heights_of(heights, corners, face, normal);
  for (int i = 0; i < 3; i++) {
    int next = (i + 1) % 3;
    if (heights[i] * heights[next] < 0.0) {
      double where = heights[i] / (heights[i] - heights[next]);
      for (int j = 0; j < 3; j++) {
        point[j] = corners[3 * i + j] + where * (corners[3 * next + j] - corners[3 * i + j]);
      }
      if (is_held(point, face, normal)) {
        return 1;
      }
    }
  }
  return 0;
}

static int is_before(const Pair* one, const Pair* other) {
  return one->mine < other->mine || (one->mine == other->mine && one->theirs < other->theirs);
}

static int is_before_gap(const Pair* one, const Gap* other) {
  return one->mine < other->mine || (one->mine == other->mine && one->theirs < other->theirs);
}

/* Whether a gap of this size is the new best one: of equal ones the first pair counts, and of its points the first. */
static int is_better(double size, const Pair* pair, const Gap* gap) {
  return size < gap->distance || (size == gap->distance && size < INFINITY && is_before_gap(pair, gap));
}

static void set_gap(Gap* gap, double size, const Pair* pair, Vector first, Vector second) {
  gap->distance = size;
  memcpy(gap->first, first, sizeof(gap->first));
  memcpy(gap->second, second, sizeof(gap->second));
  gap->mine = pair->mine;
  gap->theirs = pair->theirs;
}

/* `_face_gap` of one pair: from corners of one to the inside of the other. */
static void offer_face_gaps(Gap* gap, const Pair* pair, const double* corners, const double* face) {
  double normal[3], heights[3];
  normal_of(normal, face);
  double length = sqrt(dot(normal, normal));
  for (int i = 0; i < 3; i++) {
    normal[i] /= length;
  }
  heights_of(heights, corners, face, normal);
  for (int i = 0; i < 3; i++) {
    double foot[3], size = fabs(heights[i]);
    if (!is_better(size, pair, gap)) {
      continue;
    }
    for (int j = 0; j < 3; j++) {
      foot[j] = corners[3 * i + j] - heights[i] * normal[j];
    }
    if (is_held(foot, face, normal)) {
      set_gap(gap, size, pair, corners + 3 * i, foot);
    }
  }
}

/* `_edge_gap` of one pair. */
static void offer_edge_gaps(Gap* gap, const Pair* pair, const double* first, const double* second) {
  double sides[9];
  for (int j = 0; j < 3; j++) {
    subtract(sides + 3 * j, second + 3 * ((j + 1) % 3), second + 3 * j);
  }
  for (int i = 0; i < 3; i++) {
    double u[3];
    subtract(u, first + 3 * ((i + 1) % 3), first + 3 * i);
    double a = dot(u, u);
    for (int j = 0; j < 3; j++) {
      const double* v = sides + 3 * j;
      double r[3], away[3];
      subtract(r, first + 3 * i, second + 3 * j);
      double e = dot(v, v), b = dot(u, v), c = dot(u, r), f = dot(v, r);
      double denominator = a * e - b * b;
      double s = denominator > PARALLEL * a * e ? clip((b * f - c * e) / denominator) : 0.0;
      double t = clip((b * s + f) / e);
      s = clip((b * t - c) / a);
      for (int k = 0; k < 3; k++) {
        away[k] = r[k] + s * u[k] - t * v[k];
      }
      double square = dot(away, away);
      if (square > gap->distance * beyond(gap->distance)) { /* without a root */
        continue;
      }
      double size = sqrt(square);
      if (is_better(size, pair, gap)) {
        double one[3], other[3];
        for (int k = 0; k < 3; k++) {
          one[k] = first[3 * i + k] + s * u[k];
          other[k] = second[3 * j + k] + t * v[k];
        }
        set_gap(gap, size, pair, one, other);
      }
    }
  }
}


//------------------------------------------ batches of pairs --------------------------------------

static int is_sooner(const Pair* one, const Pair* other) {
  return one->bound < other->bound || (one->bound == other->bound && one->order < other->order);
}

static void sink(Pair* heap, int count, int at) {
  Pair moved = heap[at];
  for (int child; (child = 2 * at + 1) < count; at = child) {
    if (child + 1 < count && is_sooner(heap + child + 1, heap + child)) {
      child++;
    }
    if (!is_sooner(heap + child, &moved)) {
      break;
    }
    heap[at] = heap[child];
  }
  heap[at] = moved;
}

static void make_heap(Pair* pairs, int count) {
  for (int at = count / 2 - 1; at >= 0; at--) {
    sink(pairs, count, at);
  }
}

static Pair pop(Pair* heap, int* count) {
  Pair top = heap[0];
  heap[0] = heap[--*count];
  sink(heap, *count, 0);
  return top;
}

/* Find the first pair of a batch of which one triangle passes through the other. */
static int find_meeting(Search* s, const Pair* batch, int count, Gap* gap) {
  const Pair* met[2] = {NULL, NULL}; /* by edges of the first, by edges of the second */
  double points[2][3];
  for (int i = 0; i < count; i++) {
    const Pair* pair = batch + i;
    if (!(pair->bound <= APART) || (met[0] && is_before(met[0], pair))) {
      continue;
    }
    double first[9], second[9], point[3];
    corners_of(&s->first, pair->mine, first);
    corners_of(&s->second, pair->theirs, second);
    if (is_pierced(first, second, point)) {
      met[0] = pair;
      memcpy(points[0], point, sizeof(point));
    } else if (!met[0] && !(met[1] && is_before(met[1], pair)) && is_pierced(second, first, point)) {
      met[1] = pair;
      memcpy(points[1], point, sizeof(point));
    }
  }
  int kind = met[0] ? 0 : 1;
  if (!met[kind]) {
    return 0;
  }
  set_gap(gap, 0.0, met[kind], points[kind], points[kind]);
  return 1;
}

/* `_pairs` of a batch: its minimum gap, if it is not surely above the limit. */
static Gap gap_of(Search* s, Pair* batch, int count, double limit) {
  Gap none = {INFINITY, {NAN, NAN, NAN}, {NAN, NAN, NAN}, INT32_MAX, INT32_MAX}, gap;
  if (find_meeting(s, batch, count, &gap)) {
    return gap;
  }
  Gap face = none, back = none, edge = none;
  make_heap(batch, count);
  while (count) {
    double least = edge.distance < limit ? edge.distance : limit;
    least = face.distance < least ? face.distance : least;
    least = back.distance < least ? back.distance : least;
    if (batch[0].bound > beyond(least)) {
      break;
    }
    Pair pair = pop(batch, &count);
    double first[9], second[9];
    corners_of(&s->first, pair.mine, first);
    corners_of(&s->second, pair.theirs, second);
    offer_face_gaps(&face, &pair, first, second);
    offer_face_gaps(&back, &pair, second, first);
    offer_edge_gaps(&edge, &pair, first, second);
  }
  double swapped[3];
  memcpy(swapped, back.first, sizeof(swapped));
  memcpy(back.first, back.second, sizeof(swapped));
  memcpy(back.second, swapped, sizeof(swapped));
  gap = face;
  const Gap* others[] = {&back, &edge};
  for (int i = 0; i < 2; i++) {
    Pair pair = {0, 0, others[i]->mine, others[i]->theirs};
    if (is_better(others[i]->distance, &pair, &gap)) {
      gap = *others[i];
    }
  }
  return gap;
}

/* `_Search._compare` */
static void compare(Search* s, Pair* batch, int count) {
  Gap gap = gap_of(s, batch, count, s->best.distance);
  double before = s->best.distance;
  Pair pair = {0, 0, gap.mine, gap.theirs};
  if (gap.distance < before ||
      (gap.distance == before && s->best.mine >= 0 && is_before_gap(&pair, &s->best))) {
    s->best = gap;
    if (0.0 < gap.distance && gap.distance < MUCH * before) {
      double direction[3];
      subtract(direction, gap.second, gap.first);
      look_along(s, direction);
    }
  }
}

/* `BoxTree.below`: the first of the boxes below a box, and their number. */
static int children_of(const Surface* s, int level, int32_t box, int32_t* first) {
  if (level >= s->levels - 1) {
    *first = box;
    return 1;
  }
  *first = box * FAN;
  Py_ssize_t left = s->sizes[level] - *first;
  return left < FAN ? (int)left : FAN;
}

/* `_Search.examine`: `count` pairs of boxes stand in the list of their level. */
static void examine(Search* s, int level, int count) {
  Pair* heap = s->pairs[level];
  double most = beyond(s->best.distance);
  int near = 0;
  for (int i = 0; i < count; i++) {
    Pair pair = heap[i];
    pair.bound = bound_of(s, level, pair.mine, pair.theirs, most);
    if (pair.bound <= most) {
      pair.order = i;
      heap[near++] = pair;
    }
  }
  make_heap(heap, near);
  while (near) {
    double least = s->best.distance;
    if (least <= 0.0 || heap[0].bound > beyond(least)) {
      return;
    }
    int taken = 0;
    if (level == 0) {
      if (near <= PAIRS_AT_ONCE) { /* their order does not matter */
        memcpy(s->batch, heap, (size_t)near * sizeof(Pair));
        taken = near, near = 0;
      }
      while (near && taken < PAIRS_AT_ONCE) {
        s->batch[taken++] = pop(heap, &near);
      }
      compare(s, s->batch, taken);
      continue;
    }
    Pair batch[BOXES_AT_ONCE];
    while (near && taken < BOXES_AT_ONCE) {
      batch[taken++] = pop(heap, &near);
    }
    Pair* below = s->pairs[level - 1];
    int children = 0;
    for (int i = 0; i < taken; i++) {
      int32_t mine, theirs;
      int ours = children_of(&s->first, level - 1, batch[i].mine, &mine);
      int yours = children_of(&s->second, level - 1, batch[i].theirs, &theirs);
      for (int j = 0; j < ours; j++) {
        for (int k = 0; k < yours; k++) {
          below[children++] = (Pair){0.0, 0, mine + j, theirs + k};
        }
      }
    }
    examine(s, level - 1, children);
  }
}

/* `_Search`: search with a pair of triangles that may be the nearest, or without (-1). Return whether it was of use. */
static int search(Search* s, double limit, int32_t mine, int32_t theirs) {
  double direction[3], middle[3];
  int is_guided = 0;
  middle_of(&s->first, middle);
  middle_of(&s->second, direction);
  subtract(direction, direction, middle);
  if (mine >= 0) {
    Pair guess = {0.0, 0, mine, theirs};
    Gap gap = gap_of(s, &guess, 1, INFINITY);
    is_guided = gap.distance > 0.0 && gap.distance < INFINITY;
    if (is_guided) {
      limit = beyond(gap.distance) < limit ? beyond(gap.distance) : limit;
      subtract(direction, gap.second, gap.first);
    }
  }
  look_along(s, direction);
  s->best = (Gap){limit, {NAN, NAN, NAN}, {NAN, NAN, NAN}, -1, -1};
  int top = (s->first.levels > s->second.levels ? s->first.levels : s->second.levels) - 1;
  int count = 0;
  for (int32_t i = 0; i < s->first.sizes[s->first.levels - 1]; i++) {
    for (int32_t j = 0; j < s->second.sizes[s->second.levels - 1]; j++) {
      s->pairs[top][count++] = (Pair){0.0, 0, i, j};
    }
  }
  examine(s, top, count);
  return is_guided;
}

/* The pose of the second surface in the frame of the first. */
static void compare_poses(Search* s) {
  double away[3];
  for (int i = 0; i < 3; i++) {
    double column[3] = {s->first.turn[i], s->first.turn[3 + i], s->first.turn[6 + i]};
    turn(s->turn + 3 * i, column, s->second.turn);
  }
  for (int i = 0; i < 9; i++) {
    s->spread[i] = fabs(s->turn[i]);
  }
  subtract(away, s->second.place, s->first.place);
  turn(s->place, away, s->first.turn);
}

/* `least_gap` */
static void run(Search* s, double limit, int32_t mine, int32_t theirs) {
  compare_poses(s);
  if (search(s, limit, mine, theirs) && s->best.distance <= 0.0) {
    search(s, limit, -1, -1);
  }
}


//------------------------------------------ nearer than a margin -----------------------------------

/* Whether a plane of the boxes' sides shows that they are farther apart than `most`. */
static int boxes_are_apart(const Search* s, const double* ours, const double* yours, double most) {
  double away[3], other[3], reach[3];
  turn_back(away, yours, s->turn);
  turn_back(reach, yours + 3, s->spread);
  for (int i = 0; i < 3; i++) {
    away[i] = away[i] + s->place[i] - ours[i];
    if (fabs(away[i]) - ours[3 + i] - reach[i] > most) {
      return 1;
    }
  }
  turn(other, away, s->turn);
  turn(reach, ours + 3, s->spread);
  for (int i = 0; i < 3; i++) {
    if (fabs(other[i]) - yours[3 + i] - reach[i] > most) {
      return 1;
    }
  }
  return 0;
}

/* Whether the plane of a triangle shows that another one is farther away than `most`. */
static int plane_is_between(const double* corners, const double* face, double most) {
  double normal[3], heights[3];
  normal_of(normal, face);
  heights_of(heights, corners, face, normal);
  double enough = most * sqrt(dot(normal, normal));
  return (heights[0] > enough && heights[1] > enough && heights[2] > enough) ||
         (heights[0] < -enough && heights[1] < -enough && heights[2] < -enough);
}

/* Whether two triangles meet, or are not farther apart than the margin. */
static int triangles_come_within(const Search* s, int32_t mine, int32_t theirs, double margin, double most) {
  double first[9], second[9], point[3];
  corners_of(&s->first, mine, first);
  corners_of(&s->second, theirs, second);
  if (plane_is_between(first, second, most) || plane_is_between(second, first, most)) {
    return 0;
  }
  if (is_pierced(first, second, point) || is_pierced(second, first, point)) {
    return 1;
  }
  Pair pair = {0.0, 0, mine, theirs};
  Gap gap = {most, {0}, {0}, mine, theirs};
  offer_face_gaps(&gap, &pair, first, second);
  offer_face_gaps(&gap, &pair, second, first);
  offer_edge_gaps(&gap, &pair, first, second);
  return gap.distance <= margin;
}

/* Whether triangles below two boxes come within the margin; the larger box is divided first. */
static int boxes_come_within(const Search* s, int level, int32_t mine, int other_level, int32_t theirs, double margin,
                             double most) {
  const double *ours = box_of(&s->first, level, mine), *yours = box_of(&s->second, other_level, theirs);
  if (boxes_are_apart(s, ours, yours, most)) {
    return 0;
  }
  if (!level && !other_level) {
    return triangles_come_within(s, mine, theirs, margin, most);
  }
  int32_t child;
  if (level && (!other_level || dot(ours + 3, ours + 3) >= dot(yours + 3, yours + 3))) {
    for (int left = children_of(&s->first, level - 1, mine, &child); left; left--, child++) {
      if (boxes_come_within(s, level - 1, child, other_level, theirs, margin, most)) {
        return 1;
      }
    }
  } else {
    for (int left = children_of(&s->second, other_level - 1, theirs, &child); left; left--, child++) {
      if (boxes_come_within(s, level, mine, other_level - 1, child, margin, most)) {
        return 1;
      }
    }
  }
  return 0;
}

/* `come_within` */
static int come_within_margin(Search* s, double margin) {
  double most = beyond(margin);
  int top = s->first.levels - 1, other_top = s->second.levels - 1;
  compare_poses(s);
  for (int32_t i = 0; i < s->first.sizes[top]; i++) {
    for (int32_t j = 0; j < s->second.sizes[other_top]; j++) {
      if (boxes_come_within(s, top, i, other_top, j, margin, most)) {
        return 1;
      }
    }
  }
  return 0;
}


//------------------------------------------ boxes around geoms ------------------------------------

typedef struct {
  Py_ssize_t count, geoms;
  const Py_ssize_t *first, *second; /* (count,) */
  const double* reach; /* (count,) sum of the radii of the balls */
  const double *places, *turns, *boxes; /* (geoms, 3), (geoms, 9), (geoms, 6) */
  const char* is_plane; /* (geoms,) */
} Geoms;

/* The middle of the box around a geom, in the world. */
static void middle_of_box(double* found, const Geoms* g, Py_ssize_t geom) {
  turn_back(found, g->boxes + 6 * geom, g->turns + 9 * geom);
  for (int i = 0; i < 3; i++) {
    found[i] += g->places[3 * geom + i];
  }
}

/* Whether a plane is surely farther from the box around a geom than `most`; it is endless. */
static int is_above_plane(const Geoms* g, Py_ssize_t geom, Py_ssize_t plane, double most) {
  const double *turn_of_plane = g->turns + 9 * plane, *half = g->boxes + 6 * geom + 3;
  double normal[3] = {turn_of_plane[2], turn_of_plane[5], turn_of_plane[8]}, height[3], reach[3];
  middle_of_box(height, g, geom);
  subtract(height, height, g->places + 3 * plane);
  turn(reach, normal, g->turns + 9 * geom);
  return dot(height, normal) - (fabs(reach[0]) * half[0] + fabs(reach[1]) * half[1] + fabs(reach[2]) * half[2]) > most;
}

/* `are_apart` of one pair, with the margin in `most`. */
static int geoms_are_apart(const Geoms* g, Py_ssize_t first, Py_ssize_t second, double most) {
  if (g->is_plane[first]) {
    return is_above_plane(g, second, first, most);
  }
  if (g->is_plane[second]) {
    return is_above_plane(g, first, second, most);
  }
  const double *mine = g->turns + 9 * first, *theirs = g->turns + 9 * second;
  const double *half = g->boxes + 6 * first + 3, *other_half = g->boxes + 6 * second + 3;
  double away[3], middle[3], along[3], spread[9];
  middle_of_box(middle, g, first);
  middle_of_box(away, g, second);
  subtract(away, away, middle);
  for (int i = 0; i < 3; i++) {
    double side[3] = {mine[i], mine[3 + i], mine[6 + i]};
    turn(spread + 3 * i, side, theirs);
    for (int j = 0; j < 3; j++) {
      spread[3 * i + j] = fabs(spread[3 * i + j]);
    }
    if (fabs(dot(side, away)) - half[i] - dot(spread + 3 * i, other_half) > most) {
      return 1;
    }
  }
  turn(along, away, theirs);
  turn(middle, half, spread);
  for (int i = 0; i < 3; i++) {
    if (fabs(along[i]) - other_half[i] - middle[i] > most) {
      return 1;
    }
  }
  return 0;
}

static int is_possible(const Geoms* g, Py_ssize_t pair, double most) {
  Py_ssize_t first = g->first[pair], second = g->second[pair];
  double away[3], reach = g->reach[pair] + most;
  subtract(away, g->places + 3 * first, g->places + 3 * second);
  return dot(away, away) <= reach * reach && !geoms_are_apart(g, first, second, most);
}


//------------------------------------------ Python ------------------------------------------------

enum { CORNERS, BOXES, TURN, PLACE, ARRAYS };

/* Check the arrays of a surface, and count its levels. Return -1 with an exception if they do not fit. */
static int prepare(Surface* s, const Py_buffer* views) {
  for (int i = 0; i < ARRAYS; i++) {
    if (views[i].itemsize != (Py_ssize_t)sizeof(double) || !views[i].format || strcmp(views[i].format, "d") != 0) {
      PyErr_SetString(PyExc_TypeError, "arrays of numbers of double precision are needed");
      return -1;
    }
  }
  Py_ssize_t lengths[ARRAYS];
  for (int i = 0; i < ARRAYS; i++) {
    lengths[i] = views[i].len / (Py_ssize_t)sizeof(double);
  }
  s->corners = views[CORNERS].buf, s->boxes = views[BOXES].buf;
  s->turn = views[TURN].buf, s->place = views[PLACE].buf;
  s->count = lengths[CORNERS] / 9;
  Py_ssize_t boxes = 0, size = s->count;
  for (s->levels = 0; s->levels < MOST_LEVELS; size = (size + FAN - 1) / FAN) {
    s->starts[s->levels] = boxes;
    s->sizes[s->levels++] = size;
    boxes += size;
    if (size <= FAN) {
      break;
    }
  }
  if (lengths[CORNERS] % 9 || s->count > INT32_MAX / 2 || lengths[BOXES] != 6 * boxes || lengths[TURN] != 9 ||
      lengths[PLACE] != 3) {
    PyErr_SetString(PyExc_ValueError, "the arrays of a surface do not fit each other");
    return -1;
  }
  return 0;
}

static int is_triangle(const Surface* s, int number) { return number >= 0 && number < s->count; }

/* Give a search its memory, in one piece, which the caller frees. */
static void* furnish(Search* s) {
  Surface* surfaces[] = {&s->first, &s->second};
  int levels = s->first.levels > s->second.levels ? s->first.levels : s->second.levels;
  size_t boxes[2], pairs = (size_t)(levels - 1) * MOST_CHILDREN + FAN * FAN;
  for (int i = 0; i < 2; i++) {
    const Surface* each = surfaces[i];
    boxes[i] = (size_t)(each->starts[each->levels - 1] + each->sizes[each->levels - 1]);
  }
  size_t all = boxes[0] + boxes[1];
  /* zeros, of which the system gives large pieces only where they are used */
  char* memory = calloc(1, pairs * sizeof(Pair) + all * (sizeof(double) + sizeof(int32_t)));
  if (!memory) {
    return NULL;
  }
  Pair* room = (Pair*)memory;
  double* ends = (double*)(room + pairs);
  int32_t* known_since = (int32_t*)(ends + all);
  for (int level = 0; level < levels; level++) {
    s->pairs[level] = room + (size_t)level * MOST_CHILDREN;
  }
  for (int i = 0; i < 2; i++) {
    surfaces[i]->is_second = i;
    surfaces[i]->ends = ends + (i ? boxes[0] : 0);
    surfaces[i]->known_since = known_since + (i ? boxes[0] : 0);
  }
  return memory;
}

typedef struct {
  Search* search;
  Py_buffer views[2 * ARRAYS];
  int taken;
} Call;

static void end_call(Call* call) {
  free(call->search);
  while (call->taken) {
    PyBuffer_Release(call->views + --call->taken);
  }
}

/* Take the arrays of two surfaces. Return the search, or NULL with an exception; `end_call` in any case. */
static Search* begin_call(Call* call, PyObject** arrays) {
  for (call->taken = 0; call->taken < 2 * ARRAYS; call->taken++) {
    if (PyObject_GetBuffer(arrays[call->taken], call->views + call->taken, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) < 0) {
      return NULL;
    }
  }
  if (!(call->search = calloc(1, sizeof(Search)))) {
    PyErr_NoMemory();
    return NULL;
  }
  Search* s = call->search;
  return prepare(&s->first, call->views) < 0 || prepare(&s->second, call->views + ARRAYS) < 0 ? NULL : s;
}

PyDoc_STRVAR(least_gap_doc, "least_gap(corners, boxes, turn, place, corners, boxes, turn, place, limit, mine, theirs)\n\n"
"Do what `triangle_pairs.least_gap` does; the triangles that may be the nearest are -1 for none.\n\n"
"Return the distance, the coordinates of the two points, and the numbers of the triangles, -1 for none.");

static PyObject* least_gap(PyObject* module, PyObject* args) {
  (void)module;
  PyObject* a[2 * ARRAYS];
  double limit;
  int mine, theirs;
  if (!PyArg_ParseTuple(args, "OOOOOOOOdii", a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6, a + 7, &limit, &mine,
                        &theirs)) {
    return NULL;
  }
  PyObject* found = NULL;
  void* memory = NULL;
  Call call = {NULL, {{0}}, 0};
  Search* s = begin_call(&call, a);
  if (!s) {
    goto end;
  }
  if ((mine != -1 || theirs != -1) && !(is_triangle(&s->first, mine) && is_triangle(&s->second, theirs))) {
    PyErr_SetString(PyExc_IndexError, "there is no such triangle");
    goto end;
  }
  s->best = (Gap){limit, {NAN, NAN, NAN}, {NAN, NAN, NAN}, -1, -1};
  if (s->first.count && s->second.count) {
    if (!(memory = furnish(s))) {
      PyErr_NoMemory();
      goto end;
    }
    Py_BEGIN_ALLOW_THREADS
    run(s, limit, mine, theirs);
    Py_END_ALLOW_THREADS
  }
  const Gap* best = &s->best;
  found = Py_BuildValue("dddddddii", best->distance, best->first[0], best->first[1], best->first[2], best->second[0],
                        best->second[1], best->second[2], (int)best->mine, (int)best->theirs);
end:
  free(memory);
  end_call(&call);
  return found;
}

PyDoc_STRVAR(come_within_doc, "come_within(corners, boxes, turn, place, corners, boxes, turn, place, margin)\n\n"
"Do what `triangle_pairs.come_within` does.");

static PyObject* come_within(PyObject* module, PyObject* args) {
  (void)module;
  PyObject* a[2 * ARRAYS];
  double margin;
  if (!PyArg_ParseTuple(args, "OOOOOOOOd", a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6, a + 7, &margin)) {
    return NULL;
  }
  PyObject* found = NULL;
  Call call = {NULL, {{0}}, 0};
  Search* s = begin_call(&call, a);
  if (s) {
    int is_within;
    Py_BEGIN_ALLOW_THREADS
    is_within = come_within_margin(s, margin);
    Py_END_ALLOW_THREADS
    found = PyBool_FromLong(is_within);
  }
  end_call(&call);
  return found;
}

PyDoc_STRVAR(possible_pairs_doc, "possible_pairs(first, second, reach, places, turns, boxes, is_plane, margin)\n\n"
"Return a list of those pairs of geoms that may come nearer than the margin (m): indices of `first` and `second`.");

enum { FIRST, SECOND, REACH, PLACES, TURNS, GEOM_BOXES, IS_PLANE, GEOM_ARRAYS };

/* Return whether the arrays have the types and the sizes that fit each other. */
static int set_geoms(Geoms* g, const Py_buffer* views) {
  static const char kinds[] = "iidddd?";
  const Py_ssize_t size = sizeof(double);
  for (int i = 0; i < GEOM_ARRAYS; i++) {
    const char* format = views[i].format;
    int fits = format && (kinds[i] == 'i' ? *format == 'l' || *format == 'q' : *format == kinds[i]);
    if (!fits || views[i].itemsize != (kinds[i] == '?' ? 1 : size)) {
      return 0;
    }
  }
  *g = (Geoms){
    views[FIRST].len / (Py_ssize_t)sizeof(Py_ssize_t), views[IS_PLANE].len, views[FIRST].buf, views[SECOND].buf,
    views[REACH].buf, views[PLACES].buf, views[TURNS].buf, views[GEOM_BOXES].buf, views[IS_PLANE].buf,
  };
  if (views[SECOND].len != views[FIRST].len || views[REACH].len != g->count * size ||
      views[PLACES].len != 3 * g->geoms * size || views[TURNS].len != 9 * g->geoms * size ||
      views[GEOM_BOXES].len != 6 * g->geoms * size) {
    return 0;
  }
  for (Py_ssize_t i = 0; i < g->count; i++) {
    if (g->first[i] < 0 || g->first[i] >= g->geoms || g->second[i] < 0 || g->second[i] >= g->geoms) {
      return 0;
    }
  }
  return 1;
}

static PyObject* possible_pairs(PyObject* module, PyObject* args) {
  (void)module;
  PyObject* a[GEOM_ARRAYS];
  double margin;
  if (!PyArg_ParseTuple(args, "OOOOOOOd", a, a + 1, a + 2, a + 3, a + 4, a + 5, a + 6, &margin)) {
    return NULL;
  }
  Py_buffer views[GEOM_ARRAYS];
  int taken = 0;
  PyObject* found = NULL;
  Geoms g;
  for (; taken < GEOM_ARRAYS; taken++) {
    if (PyObject_GetBuffer(a[taken], views + taken, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) < 0) {
      goto end;
    }
  }
  if (!set_geoms(&g, views)) {
    PyErr_SetString(PyExc_ValueError, "the arrays of pairs and geoms do not fit each other");
    goto end;
  }
  found = PyList_New(0);
  for (Py_ssize_t i = 0; found && i < g.count; i++) {
    if (!is_possible(&g, i, margin + ROUNDING)) {
      continue;
    }
    PyObject* number = PyLong_FromSsize_t(i);
    if (!number || PyList_Append(found, number) < 0) {
      Py_CLEAR(found);
    }
    Py_XDECREF(number);
  }
end:
  while (taken) {
    PyBuffer_Release(views + --taken);
  }
  return found;
}

static PyMethodDef functions[] = {
  {"least_gap", least_gap, METH_VARARGS, least_gap_doc},
  {"come_within", come_within, METH_VARARGS, come_within_doc},
  {"possible_pairs", possible_pairs, METH_VARARGS, possible_pairs_doc},
  {NULL, NULL, 0, NULL},
};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_triangle_pairs", "Distances of surfaces, compiled.", -1, functions, NULL, NULL, NULL, NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

PyMODINIT_FUNC PyInit__triangle_pairs(void) {
  PyObject* module = PyModule_Create(&definition);
  if (module && PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_DECREF(module);
    return NULL;
  }
  return module;
}
