/* The first triangle that a ray meets: what `_Ray` in ../first_hit.py does in Python.

   The search leaves out what the ray surely misses, with bounds wider than rounding. The numbers of what is left are
   computed with the same operations in the same order as in Python, so both forms give the same results bit for bit; the
   build forbids fused multiplications (-ffp-contract=off). Python leaves sums of products to NumPy, which adds and fuses
   them as the processor likes: `ways` finds out how, and without an answer the module is not used. A formula that
   changes here changes there; tests/server/sensors/proximity/test_single_rays.py holds both equal. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define FAN 8          /* triangles below a box, and boxes below a box */
#define MOST_LEVELS 21 /* enough for all numbers of triangles that fit into memory */

/* as in ../first_hit.py */
#define SLACK 1e-6
#define THIN 1e-16

#define MARGIN (2 * SLACK) /* metres, and a share of lengths: what is nearer is examined exactly */
#define STEEP 1e-6         /* cosine up to which the height of a plane is not computed before */

enum { TRIANGLES, CURVED, PLANE };          /* how the surface of a geom is met */
enum { BOTH, FRONT, BACK };                 /* the sides of a surface that the sensor sees */
enum { IN_TURN, FUSED, MATRIX_WAYS };       /* how NumPy sums the three products of a matrix product */
enum { ENDS_FIRST, ENDS_FUSED, ONE_BY_ONE, ALL_FUSED, SUM_WAYS }; /* and those of einsum("ni,ni->n") */


//------------------------------------------ NumPy's sums --------------------------------------------

/* One number of the product of a row and a matrix (3, 3). */
static double row_times(const double* row, const double* column, int way) {
  double sum = row[0] * column[0];
  if (way == FUSED) {
    return fma(row[2], column[6], fma(row[1], column[3], sum));
  }
  return sum + row[1] * column[3] + row[2] * column[6];
}

static double dot(const double* a, const double* b, int way) {
  switch (way) {
    case ENDS_FIRST:
      return (a[0] * b[0] + a[2] * b[2]) + a[1] * b[1];
    case ENDS_FUSED:
      return fma(a[2], b[2], a[0] * b[0]) + a[1] * b[1];
    case ONE_BY_ONE:
      return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    default:
      return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]));
  }
}


static double lesser(double a, double b) { return b < a ? b : a; }
static double greater(double a, double b) { return b > a ? b : a; }
static double least_of(double a, double b, double c) { return lesser(lesser(a, b), c); }
static double greatest_of(double a, double b, double c) { return greater(greater(a, b), c); }


//------------------------------------------ trees of boxes ------------------------------------------

typedef struct {
  Py_buffer view; /* without an object until the geom is near a ray */
  const double* corners; /* (count, 9) */
  Py_ssize_t count;
  int levels;
  Py_ssize_t starts[MOST_LEVELS], sizes[MOST_LEVELS]; /* of the levels among the boxes */
  double* boxes; /* (boxes, 6) least and greatest coordinates */
} Form;

static void widen(double* box, const double* low, const double* high) {
  for (int i = 0; i < 3; i++) {
    box[i] = low[i] < box[i] ? low[i] : box[i];
    box[3 + i] = high[i] > box[3 + i] ? high[i] : box[3 + i];
  }
}

/* Make the boxes over all triangles; neighbours follow each other. Return -1 without memory. */
static int build(Form* f) {
  Py_ssize_t boxes = 0, size = f->count;
  for (f->levels = 0; f->levels < MOST_LEVELS && size;) {
    size = (size + FAN - 1) / FAN;
    f->starts[f->levels] = boxes;
    f->sizes[f->levels++] = size;
    boxes += size;
    if (size <= FAN) {
      break;
    }
  }
  if (!(f->boxes = malloc((size_t)(boxes + 1) * 6 * sizeof(double)))) {
    return -1;
  }
  for (int level = 0; level < f->levels; level++) {
    for (Py_ssize_t i = 0; i < f->sizes[level]; i++) {
      double* box = f->boxes + 6 * (f->starts[level] + i);
      Py_ssize_t below = level ? f->sizes[level - 1] : f->count;
      for (int j = 0; j < 3; j++) {
        box[j] = INFINITY, box[3 + j] = -INFINITY;
      }
      for (Py_ssize_t child = FAN * i; child < FAN * (i + 1) && child < below; child++) {
        if (level) {
          const double* other = f->boxes + 6 * (f->starts[level - 1] + child);
          widen(box, other, other + 3);
        } else {
          for (const double* corner = f->corners + 9 * child; corner < f->corners + 9 * (child + 1); corner += 3) {
            widen(box, corner, corner);
          }
        }
      }
    }
  }
  return 0;
}

static void release(Form* f) {
  PyBuffer_Release(&f->view); /* does nothing without an object */
  free(f->boxes);
  memset(f, 0, sizeof(Form));
}


//------------------------------------------ one ray -------------------------------------------------

typedef struct {
  double offset, reach; /* metres; the reach is that to the best hit */
  double least_cosine;
  int faces, matrix_way, sum_way;
  Py_ssize_t geom, row; /* of the best hit; -1: none */
  double normal[3];
} Ray;

typedef struct {
  double turn[9];            /* rows are the geom's axes in the sensor's frame */
  double place[3];           /* the geom's origin in the sensor's frame */
  double start[3], along[3]; /* the sensor's origin and z axis in the geom's frame */
  double farthest;           /* the greatest coordinate of the start */
  Py_ssize_t geom;
  double low; /* where the ray may enter the box around it */
} View;

static double end_of(const Ray* ray) { return ray->offset + ray->reach; }

/* Whether the ray may meet a box, and where it may enter it. */
static int enters(const Ray* ray, const View* v, const double* low, const double* high, double* height) {
  double first = ray->offset - MARGIN, last = end_of(ray) + MARGIN, size = v->farthest;
  for (int i = 0; i < 3; i++) {
    size = greater(size, greater(fabs(low[i]), fabs(high[i])));
  }
  double margin = MARGIN * (1.0 + size);
  for (int i = 0; i < 3; i++) {
    double below = low[i] - margin - v->start[i], above = high[i] + margin - v->start[i], along = v->along[i];
    if (fabs(along) < 1e-9) { /* it hardly moves along this axis */
      double drift = fabs(along) * greater(fabs(ray->offset), fabs(end_of(ray)));
      if (!(below <= drift && above >= -drift)) {
        return 0;
      }
      continue;
    }
    double one = below / along, other = above / along;
    first = greater(first, lesser(one, other) - MARGIN);
    last = lesser(last, greater(one, other) + MARGIN);
    if (!(first <= last)) {
      return 0;
    }
  }
  *height = first;
  return 1;
}

/* `Optics.accepts` for a point on the axis. */
static int accepts(const Ray* ray, double away, double cosine) {
  double along = away * cosine;
  if (ray->faces != BOTH && (along < 0) != (ray->faces == FRONT)) {
    return 0;
  }
  return fabs(along) >= ray->least_cosine * fabs(away);
}

/* `_Ray._offer` */
static void offer(Ray* ray, Py_ssize_t geom, Py_ssize_t row, double distance, const double* normal) {
  if (distance > ray->reach) {
    return;
  }
  if (ray->geom >= 0 && distance == ray->reach && (geom > ray->geom || (geom == ray->geom && row >= ray->row))) {
    return;
  }
  if (accepts(ray, ray->offset + distance, normal[2])) {
    ray->reach = distance, ray->geom = geom, ray->row = row;
    memcpy(ray->normal, normal, sizeof(ray->normal));
  }
}

/* `_holds` */
static int holds(double (*corners)[3], const double* normal, double z) {
  double u = normal[0], v = normal[1], w = normal[2];
  for (int i = 0; i < 3; i++) {
    const double *a = corners[i], *next = corners[(i + 1) % 3];
    double bx = next[0] - a[0], by = next[1] - a[1], bz = next[2] - a[2];
    double x = v * bz - w * by, y = w * bx - u * bz, up = u * by - v * bx;
    if (!(z * up >= x * a[0] + y * a[1] + up * a[2] - 1e-9 * sqrt(x * x + y * y + up * up))) {
      return 0;
    }
  }
  return 1;
}

/* A step of `_crossings`, and the offer. */
static void try_triangle(Ray* ray, const View* view, const double* corners, Py_ssize_t row) {
  double p[3][3]; /* the corners in the sensor's frame */
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      p[i][j] = row_times(corners + 3 * i, view->turn + j, ray->matrix_way) + view->place[j];
    }
  }
  const double *a = p[0], *b = p[1], *c = p[2];
  double bottom = least_of(a[2], b[2], c[2]), top = greatest_of(a[2], b[2], c[2]);
  if (top < ray->offset - SLACK || bottom > end_of(ray) + SLACK) {
    return;
  }
  double first = a[0] * b[1] - b[0] * a[1], second = b[0] * c[1] - c[0] * b[1], third = c[0] * a[1] - a[0] * c[1];
  double slack = SLACK * (SLACK + fabs(a[0]) + fabs(a[1]) + fabs(b[0]) + fabs(b[1]) + fabs(c[0]) + fabs(c[1]));
  double least = least_of(first, second, third), greatest = greatest_of(first, second, third);
  if (!(least >= -slack || greatest <= slack)) { /* the axis passes edges on both sides */
    return;
  }
  double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2], cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
  double product[3] = {by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx};
  double length = sqrt(dot(product, product, ray->sum_way));
  length = length > 1e-300 ? length : 1e-300;
  double normal[3] = {product[0] / length, product[1] / length, product[2] / length};
  double height = dot(normal, a, ray->sum_way);
  if (length > THIN && normal[2] != 0.0) {
    double z = height / normal[2];
    if ((least > slack || greatest < -slack || holds(p, normal, z)) && z >= ray->offset) {
      offer(ray, view->geom, row, z - ray->offset, normal);
    }
  }
}

static void descend(Ray* ray, const View* v, const Form* f, int level, Py_ssize_t number) {
  double height;
  const double* box = f->boxes + 6 * (f->starts[level] + number);
  if (!enters(ray, v, box, box + 3, &height)) {
    return;
  }
  Py_ssize_t below = level ? f->sizes[level - 1] : f->count;
  for (Py_ssize_t child = FAN * number; child < FAN * (number + 1) && child < below; child++) {
    if (level) {
      descend(ray, v, f, level - 1, child);
    } else {
      try_triangle(ray, v, f->corners + 9 * child, child);
    }
  }
}

static void search(Ray* ray, const View* v, const Form* f) {
  for (Py_ssize_t i = 0; f->levels && i < f->sizes[f->levels - 1]; i++) {
    descend(ray, v, f, f->levels - 1, i);
  }
}

/* Whether the ray may meet a plane, and where: its back is not met, but to know that is not needed. */
static int crosses(const Ray* ray, const View* v, double* height) {
  double end = end_of(ray), here = v->start[2] + ray->offset * v->along[2], there = v->start[2] + end * v->along[2];
  double margin = MARGIN * (1.0 + v->farthest + greater(fabs(ray->offset), fabs(end)));
  if ((here > margin && there > margin) || (here < -margin && there < -margin)) {
    return 0;
  }
  *height = ray->offset;
  if (fabs(v->along[2]) > STEEP) {
    *height = greater(ray->offset, -v->start[2] / v->along[2] - margin / fabs(v->along[2]));
  }
  return 1;
}


//------------------------------------------ the geoms -----------------------------------------------

typedef struct {
  PyObject_HEAD
  Py_ssize_t count;
  char* roles;    /* (count,) */
  double* boxes;  /* (count, 6) middle and half sides in the geom's frame */
  double* radii;  /* (count,) of balls around the geoms; infinite for planes */
  Form* forms;    /* (count,) */
  View* views;    /* (count,) room for the geoms near a ray: first those with triangles, last the others */
  PyObject* triangles;
  int matrix_way, sum_way;
} Surfaces;

/* Take an array. Return -1 with an exception if it does not fit. */
static int take(PyObject* array, Py_buffer* view, const char* format, Py_ssize_t bytes) {
  if (PyObject_GetBuffer(array, view, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) < 0) {
    return -1;
  }
  if (!view->format || strcmp(view->format, format) != 0 || (bytes >= 0 && view->len != bytes)) {
    PyBuffer_Release(view);
    PyErr_SetString(PyExc_ValueError, "an array has another type or size than the geoms need");
    return -1;
  }
  return 0;
}

/* Ask for the triangles of a geom, unless they are here. Return -1 with an exception. */
static int load(Surfaces* s, Py_ssize_t geom) {
  if (s->forms[geom].view.obj) {
    return 0;
  }
  PyObject* array = PyObject_CallFunction(s->triangles, "n", geom);
  if (!array) {
    return -1;
  }
  Form form = {0};
  int is_taken = take(array, &form.view, "d", -1);
  Py_DECREF(array); /* the view holds it */
  if (is_taken < 0) {
    return -1;
  }
  form.corners = form.view.buf, form.count = form.view.len / (9 * (Py_ssize_t)sizeof(double));
  if (build(&form) < 0) {
    release(&form);
    PyErr_NoMemory();
    return -1;
  }
  release(&s->forms[geom]); /* the call may have come here too */
  s->forms[geom] = form;
  return 0;
}

static void look_from(View* v, const double* xmat, const double* place, const double* rotation, int way) {
  for (int i = 0; i < 3; i++) {
    double row[3] = {xmat[i], xmat[3 + i], xmat[6 + i]};
    for (int j = 0; j < 3; j++) {
      v->turn[3 * i + j] = row_times(row, rotation + j, way);
    }
    v->place[i] = place[i];
  }
  for (int i = 0; i < 3; i++) {
    const double* axis = v->turn + 3 * i;
    v->start[i] = -(axis[0] * place[0] + axis[1] * place[1] + axis[2] * place[2]);
    v->along[i] = axis[2];
  }
  v->farthest = greatest_of(fabs(v->start[0]), fabs(v->start[1]), fabs(v->start[2]));
}

static int by_height(const void* one, const void* other) {
  double a = ((const View*)one)->low, b = ((const View*)other)->low;
  return (a > b) - (a < b);
}

/* Note the geoms that the ray may meet: `near` with triangles at the start of the views, `others` at their end. */
static void approach(Surfaces* s, const Ray* ray, const double* places, const double* xmat, const double* rotation,
                     const char* wanted, Py_ssize_t* near, Py_ssize_t* others) {
  double half = ray->reach / 2, middle = ray->offset + half;
  *near = *others = 0;
  for (Py_ssize_t geom = 0; geom < s->count; geom++) {
    const double* place = places + 3 * geom;
    double radius = s->radii[geom] * (1.0 + MARGIN) + MARGIN;
    if (!wanted[geom] || !(place[0] * place[0] + place[1] * place[1] <= radius * radius) ||
        !(fabs(place[2] - middle) <= radius + half + MARGIN)) {
      continue;
    }
    View v;
    v.geom = geom;
    look_from(&v, xmat + 9 * geom, place, rotation, s->matrix_way);
    const double* box = s->boxes + 6 * geom;
    double low[3] = {box[0] - box[3], box[1] - box[4], box[2] - box[5]};
    double high[3] = {box[0] + box[3], box[1] + box[4], box[2] + box[5]};
    if (s->roles[geom] == PLANE ? crosses(ray, &v, &v.low) : enters(ray, &v, low, high, &v.low)) {
      s->views[s->roles[geom] == TRIANGLES ? (*near)++ : s->count - ++*others] = v;
    }
  }
  qsort(s->views, (size_t)*near, sizeof(View), by_height);
}

PyDoc_STRVAR(first_doc, "first(places, xmat, rotation, wanted, offset, reach, faces, least_cosine)\n\n"
"Return the first triangle on a sensor's z axis: its geom, -1 for none; its number; the distance from the ray's start\n"
"in metres; the normal in the sensor's frame; and a list of the planes and curved geoms that may be met before.\n\n"
"places: (ngeom, 3) origins of the geoms in the sensor's frame.\n"
"xmat: (ngeom, 9) rotations of the geoms in the world.\n"
"rotation: (3, 3) of the sensor in the world.\n"
"wanted: (ngeom,) the geoms to detect.\n"
"offset, reach: metres.\n"
"faces: 0 both, 1 front, 2 back.\n"
"least_cosine: of the angle between ray and normal.");

static PyObject* first(PyObject* self, PyObject* args) {
  Surfaces* s = (Surfaces*)self;
  PyObject* arrays[4];
  Ray ray = {.geom = -1, .row = -1, .matrix_way = s->matrix_way, .sum_way = s->sum_way};
  if (!PyArg_ParseTuple(args, "OOOOddid", arrays, arrays + 1, arrays + 2, arrays + 3, &ray.offset, &ray.reach, &ray.faces,
                        &ray.least_cosine)) {
    return NULL;
  }
  const Py_ssize_t real = sizeof(double), sizes[4] = {3 * real * s->count, 9 * real * s->count, 9 * real, s->count};
  Py_buffer views[4];
  int taken = 0;
  PyObject *result = NULL, *list = PyList_New(0);
  for (; list && taken < 4; taken++) {
    if (take(arrays[taken], views + taken, taken < 3 ? "d" : "?", sizes[taken]) < 0) {
      goto end;
    }
  }
  Py_ssize_t near, others;
  approach(s, &ray, views[0].buf, views[1].buf, views[2].buf, views[3].buf, &near, &others);
  for (Py_ssize_t i = 0; list && i < near; i++) {
    View v = s->views[i];
    if (v.low > end_of(&ray) + MARGIN) {
      break;
    }
    if (load(s, v.geom) < 0) {
      goto end;
    }
    search(&ray, &v, &s->forms[v.geom]);
  }
  for (Py_ssize_t i = s->count - others; list && i < s->count; i++) {
    if (s->views[i].low <= end_of(&ray) + MARGIN) {
      PyObject* geom = PyLong_FromSsize_t(s->views[i].geom);
      if (!geom || PyList_Append(list, geom) < 0) {
        Py_CLEAR(list);
      }
      Py_XDECREF(geom);
    }
  }
  if (list) {
    result = Py_BuildValue("nnd(ddd)O", ray.geom, ray.row, ray.reach, ray.normal[0], ray.normal[1], ray.normal[2], list);
  }
end:
  Py_XDECREF(list);
  while (taken) {
    PyBuffer_Release(views + --taken);
  }
  return result;
}

static void* copied(PyObject* array, const char* format, Py_ssize_t bytes) {
  Py_buffer view;
  if (take(array, &view, format, bytes) < 0) {
    return NULL;
  }
  void* memory = malloc((size_t)view.len + 1);
  if (memory) {
    memcpy(memory, view.buf, (size_t)view.len);
  } else {
    PyErr_NoMemory();
  }
  PyBuffer_Release(&view);
  return memory;
}

static PyObject* make(PyTypeObject* type, PyObject* args, PyObject* keywords) {
  static char* names[] = {"roles", "boxes", "radii", "triangles", "ways", NULL};
  PyObject *roles, *boxes, *radii, *triangles;
  int matrix_way, sum_way;
  if (!PyArg_ParseTupleAndKeywords(args, keywords, "OOOO(ii)", names, &roles, &boxes, &radii, &triangles, &matrix_way,
                                   &sum_way)) {
    return NULL;
  }
  Py_ssize_t count = PyObject_Length(roles);
  if (count < 0) {
    return NULL;
  }
  allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
  Surfaces* s = (Surfaces*)allocate(type, 0); /* zeroed */
  if (!s) {
    return NULL;
  }
  const Py_ssize_t real = sizeof(double);
  s->count = count, s->matrix_way = matrix_way, s->sum_way = sum_way;
  Py_INCREF(triangles);
  s->triangles = triangles;
  if (!(s->roles = copied(roles, "b", count)) || !(s->boxes = copied(boxes, "d", 6 * real * count)) ||
      !(s->radii = copied(radii, "d", real * count))) {
    goto fail;
  }
  s->forms = calloc((size_t)count + 1, sizeof(Form));
  s->views = calloc((size_t)count + 1, sizeof(View));
  if (!s->forms || !s->views) {
    PyErr_NoMemory();
    goto fail;
  }
  return (PyObject*)s;

fail:
  Py_DECREF(s);
  return NULL;
}

static void forget(PyObject* self) {
  Surfaces* s = (Surfaces*)self;
  PyTypeObject* type = Py_TYPE(self);
  for (Py_ssize_t i = 0; s->forms && i < s->count; i++) {
    release(&s->forms[i]);
  }
  free(s->roles), free(s->boxes), free(s->radii), free(s->forms), free(s->views);
  Py_XDECREF(s->triangles);
  freefunc release_memory = (freefunc)PyType_GetSlot(type, Py_tp_free);
  release_memory(self);
  Py_DECREF(type);
}

static PyMethodDef methods[] = {{"first", first, METH_VARARGS, first_doc}, {NULL, NULL, 0, NULL}};

static PyType_Slot slots[] = {{Py_tp_new, make}, {Py_tp_dealloc, forget}, {Py_tp_methods, methods}, {0, NULL}};

static PyType_Spec spec = {
  "simx_server.sensors.proximity.native._first_hit.Surfaces", sizeof(Surfaces), 0, Py_TPFLAGS_DEFAULT, slots,
};

PyDoc_STRVAR(ways_doc, "ways(a, b, products, sums)\n\n"
"Return how NumPy sums the products of three numbers here, for `Surfaces`: in matrices, and in einsum. None: unknown.\n\n"
"a, b: (n, 3, 3) any numbers.\n"
"products: (n, 3, 3) a @ b.\n"
"sums: (n, 3) einsum(\"nij,nij->ni\", a, b).");

static PyObject* ways(PyObject* module, PyObject* args) {
  (void)module;
  PyObject* arrays[4];
  if (!PyArg_ParseTuple(args, "OOOO", arrays, arrays + 1, arrays + 2, arrays + 3)) {
    return NULL;
  }
  Py_ssize_t count = PyObject_Length(arrays[0]);
  if (count < 0) {
    return NULL;
  }
  Py_buffer views[4];
  const double* numbers[4];
  int taken = 0, matrix_way = -1, sum_way = -1;
  for (; taken < 4; taken++) {
    if (take(arrays[taken], views + taken, "d", (taken < 3 ? 9 : 3) * count * (Py_ssize_t)sizeof(double)) < 0) {
      goto end;
    }
    numbers[taken] = views[taken].buf;
  }
  for (int way = 0, is_so; way < MATRIX_WAYS && matrix_way < 0; way++) {
    is_so = 1;
    for (Py_ssize_t i = 0; i < 9 * count && is_so; i++) {
      const double *row = numbers[0] + i / 3 * 3, *column = numbers[1] + i / 9 * 9 + i % 3;
      is_so = row_times(row, column, way) == numbers[2][i];
    }
    matrix_way = is_so ? way : -1;
  }
  for (int way = 0, is_so; way < SUM_WAYS && sum_way < 0; way++) {
    is_so = 1;
    for (Py_ssize_t i = 0; i < 3 * count && is_so; i++) {
      is_so = dot(numbers[0] + 3 * i, numbers[1] + 3 * i, way) == numbers[3][i];
    }
    sum_way = is_so ? way : -1;
  }
end:
  while (taken) {
    PyBuffer_Release(views + --taken);
  }
  if (PyErr_Occurred()) {
    return NULL;
  }
  if (matrix_way < 0 || sum_way < 0) {
    Py_INCREF(Py_None);
    return Py_None;
  }
  return Py_BuildValue("(ii)", matrix_way, sum_way);
}

static PyMethodDef functions[] = {{"ways", ways, METH_VARARGS, ways_doc}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef definition = {
  PyModuleDef_HEAD_INIT, "_first_hit", "The first triangle that a ray meets, compiled.", -1, functions,
  NULL, NULL, NULL, NULL,
};

#ifndef SOURCE_HASH
#define SOURCE_HASH ""
#endif

PyMODINIT_FUNC PyInit__first_hit(void) {
  PyObject* module = PyModule_Create(&definition);
  PyObject* type = module ? PyType_FromSpec(&spec) : NULL;
  if (!type || PyModule_AddObjectRef(module, "Surfaces", type) < 0 ||
      PyModule_AddStringConstant(module, "SOURCE_HASH", SOURCE_HASH) < 0) {
    Py_CLEAR(module);
  }
  Py_XDECREF(type);
  return module;
}
