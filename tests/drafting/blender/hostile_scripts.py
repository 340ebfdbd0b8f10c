"""Scripts that a reader must refuse at once: a name, the text, and the line that the message names."""

import re

_NESTED = "a = [1]\nb = [1]\nfor _ in range(60):\n    a = [a, a]\n    b = [b, b]\n"
_CUBE = "import bpy\nbpy.ops.mesh.primitive_cube_add()\n"
_MESH = "import bmesh\nbm = bmesh.new()\n"
_CLASS = "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass A:\n"
_CHILDREN = "import bpy\nc=bpy.context.scene.collection\nfor i in range(3000):\n    "
_CHILDREN += "c.children.link(bpy.data.collections.new('a'))\n"
_SLOW = "class A:\n    @property\n    def x(self):\n        while True:\n            pass\n"
_MANY_NAMES = "".join(f"    a{k} = {k}\n" for k in range(6000))
# fmt: off
HOSTILE: list[tuple[str, str, int]] = [
    # what reaches outside
    ("import os", "import bpy\nimport os\nos.system('echo')", 3),
    ("from import", "from subprocess import run\nrun(['true'])", 2),
    ("star import", "from os import *", 1),
    ("relative import", "from . import secrets", 1),
    ("import by name", "m = __import__('os')", 1),
    ("importlib", "import importlib\nimportlib.import_module('os')", 2),
    ("builtins", "import builtins\nbuiltins.eval('1')", 2),
    ("open", "x = 1\nopen('/etc/passwd').read()", 2),
    ("eval", "eval('1+1')", 1),
    ("exec", "exec('import os')", 1),
    ("type with three arguments", "type('X', (), {})", 1),
    ("dunder walk of a tuple", "().__class__.__bases__[0].__subclasses__()", 1),
    ("dunder walk of a module", "import math\nmath.__loader__", 2),
    ("dunder that is set", "import bpy\nbpy.context.scene.__class__ = 1", 2),
    ("file name", "__file__", 1),
    ("walk in a format", "'{0.__class__}'.format(1)", 1),
    ("index in a format", "'{0[0]}'.format([1])", 1),
    ("format_map", "'{x}'.format_map({'x': 1})", 1),
    ("walk in an f-string", "x = 1\nf'{x.__class__}'", 2),
    ("generator frame", "g = (i for i in range(3))\ng.gi_frame", 2),
    ("decorator", "def d(f):\n    return f\n@d\ndef g():\n    pass", 3),
    ("metaclass", "class M:\n    pass\nclass A(metaclass=M):\n    pass", 3),
    ("class of several", "class A:\n    pass\nclass B(A, object):\n    pass", 3),
    ("class of an error", "class A(BaseException):\n    pass", 1),
    ("getattr method", "class A:\n    def __getattr__(self, n):\n        return self\nA().x", 2),
    ("dict of an instance", "class A:\n    pass\nA().__dict__['x'] = 1", 3),
    ("dunder of a method", "class A:\n    def f(self):\n        pass\nA().f.__func__.__globals__", 4),
    ("class by a call of type", "class A:\n    pass\ntype(A(), (), {})", 3),
    ("classes of classes", "class A:\n    pass\nfor i in range(99):\n    class A(A):\n        pass", 4),
    ("instances without end", "class A:\n    pass\na = []\nwhile True:\n    a.append(A())", 4),
    ("decorator of another", "@eval\ndef f():\n    pass", 1),
    ("namedtuple of dunders", "from collections import namedtuple\nnamedtuple('A', '__class__ x')", 2),
    ("factories of factories", "from collections import defaultdict\nf = lambda: defaultdict(f)\nx = f()\nwhile 1:\n"
     "    x = x[0]", 5),
    ("product with itself", "import itertools\nitertools.product(range(99), repeat=9)", 2),
    ("permutations", "import itertools\nitertools.permutations(range(16))", 2),
    ("count without end", "import itertools\nfor i in itertools.count():\n    pass", 2),
    ("list of a cycle", "import itertools\nlist(itertools.cycle([1]))", 2),
    ("zip of counts", "import itertools\nlist(zip(itertools.count(), itertools.count()))", 2),
    ("partial of partial", "from functools import partial\nf = print\nwhile True:\n    f = partial(f, 1)", 4),
    ("caught for ever", "while True:\n    try:\n        {}['a']\n    except KeyError:\n        continue", 2),
    ("caught recursion", "def f():\n    try:\n        f()\n    except Exception:\n        f()\nf()", 3),
    ("a refusal that is caught", "try:\n    import os\nexcept Exception:\n    pass", 2),
    ("sleeping", "import time\ntime.sleep(9999)", 2),
    ("vertices of bmesh", "import bmesh\nbm = bmesh.new()\nwhile True:\n    bm.verts.new((0, 0, 0))", 4),
    ("columns of bmesh", "import bmesh\nbm = bmesh.new()\nbmesh.ops.create_grid(bm, x_segments=10**6)", 3),
    ("grid of bmesh", "import bmesh\nbm = bmesh.new()\nbmesh.ops.create_grid(bm, x_segments=500, y_segments=500)", 3),
    ("faces of bmesh", _MESH + "v = [bm.verts.new() for i in range(3)]\nwhile 1:\n    bm.faces.new(v)", 5),
    ("copies of bmesh", "import bmesh\nbm = bmesh.new()\nbmesh.ops.create_cube(bm)\nwhile 1:\n    bm = bm.copy()", 5),
    ("doubling bmesh", _MESH + "bmesh.ops.create_cube(bm)\nwhile 1:\n"
     "    bmesh.ops.extrude_face_region(bm, geom=bm.faces)", 5),
    ("long array", _CUBE + "bpy.context.object.modifiers.new('a', 'ARRAY').count = 10**9", 3),
    ("arrays of arrays", _CUBE + "c = bpy.context.object\nfor i in range(8):\n"
     "    c.modifiers.new('a', 'ARRAY').count = 99\nc.name = 'Car'", 2),
    ("a size beyond all", "import bpy\nbpy.ops.mesh.primitive_cube_add(size=1e250)\n"
     "bpy.context.object.name = 'Car'", 2),
    ("`with` that overrides", "import bpy\nwith bpy.context.temp_override(x=1) as f:\n    pass", 2),
    ("class that hides an operator", "class A(str):\n    def __add__(self, o):\n        return self", 1),
    ("match", "x = 1\nmatch x:\n    case 1:\n        pass", 2),
    ("with", "with open('a') as f:\n    pass", 1),
    ("await", "await x", 1),
    ("yield for ever", "def f():\n    while True:\n        yield 1\nfor x in f(): pass", 3),
    ("handlers", "import bpy\nbpy.app.handlers.frame_change_pre.append(print)", 2),
    ("scripts of Blender", "import bpy\nbpy.ops.script.python_file_run(filepath='a.py')", 2),
    ("images of Blender", "import bpy\nbpy.data.images.load('/etc/passwd')", 2),
    ("libraries of Blender", "import bpy\nbpy.data.libraries.load('a.blend')", 2),
    ("another importer", "import bpy\nbpy.ops.import_scene.gltf(filepath='a.glb')", 2),
    # what never ends
    ("while True", "while True:\n    pass", 1),
    ("try and finally", "while True:\n    try:\n        break\n    finally:\n        continue", 3),
    ("a list that grows under a loop", "a = [1]\nfor x in a:\n    a.append(x)", 3),
    ("recursion", "def f(n):\n    return f(n + 1)\nf(0)", 2),
    ("mutual recursion", "def f():\n    g()\ndef g():\n    f()\nf()", 4),
    ("lambda recursion", "(lambda f: f(f))(lambda f: f(f))", 1),
    ("recursion that doubles", "def f(n):\n    f(n - 1) if n else 0\n    f(n - 1) if n else 0\nf(24)", 2),
    ("exponential closures", "f = lambda x: x\nfor i in range(64):\n    f = (lambda g: lambda x: g(g(x)))(f)\nf(1)", 3),
    ("sorting by a slow key", "sorted(range(10**5), key=lambda x: sum(range(1000)))", 1),
    ("shuffling", "import random\na = list(range(200000))\nfor i in range(100):\n    random.shuffle(a)", 4),
    ("comparing shared lists", "a = []\nb = []\nfor i in range(99):\n    a = [a, a]\n    b = [b, b]\na == b", 6),
    ("writing shared lists", "a = []\nfor i in range(99):\n    a = [a, a]\nstr(a)", 4),
    ("a list within itself", "a = []\na.append(a)\nprint(str(a))", 3),
    ("membership", "a = list(range(100000))\nfor i in range(10**6):\n    -1 in a", 3),
    ("objects", "import bpy\nwhile True:\n    bpy.ops.mesh.primitive_cube_add()", 3),
    ("copies", "import bpy\nbpy.ops.mesh.primitive_cube_add()\nwhile 1:\n    bpy.context.object.copy()", 4),
    ("duplicates", "import bpy\nbpy.ops.mesh.primitive_cube_add()\nwhile 1:\n    bpy.ops.object.duplicate()", 4),
    ("a circle of parents", "import bpy\nbpy.ops.object.empty_add()\na = bpy.context.object\na.parent = a", 4),
    # what is too large
    ("power", "x = 9 ** 9 ** 9", 1),
    ("repeated squares", "x = 10\nwhile True:\n    x = x * x", 3),
    ("shift", "x = 1 << 10**10", 1),
    ("factorial", "import math\nmath.factorial(10**6)", 2),
    ("rounding", "round(5, -10**9)", 1),
    ("number of many digits", "int('9' * 5000)", 1),
    ("literal of many digits", "x = 1\ny = " + "9" * 3000, 2),
    ("string doubling", "x = 'a'\nwhile True:\n    x = x + x", 3),
    ("string multiplication", "x = 'a' * 10**10", 1),
    ("string join", "''.join(['a' * 1000] * 10**6)", 1),
    ("string replace", "('a' * 10**5).replace('a', 'b' * 10**5)", 1),
    ("replace of nothing", "('a' * 10**5).replace('', 'b' * 10**5)", 1),
    ("string width", "'a'.ljust(10**10)", 1),
    ("f-string width", "f'{1:{10**9}}'", 1),
    ("nested f-string width", "f'{f\"{1:>{9**9}}\":>{9**9}}'", 1),
    ("percent width", "'%999999999d' % 1", 1),
    ("list multiplication", "x = [0] * 10**10", 1),
    ("list doubling", "x = [0]\nwhile True:\n    x = x + x", 3),
    ("list extended by itself", "x = [0]\nwhile True:\n    x.extend(x)", 3),
    ("list += itself", "x = [0]\nwhile True:\n    x += x", 3),
    ("slice assignment", "x = [0]\nwhile True:\n    x[:] = x + x", 3),
    ("list of a range", "list(range(10**10))", 1),
    ("sum of a range", "sum(range(10**10))", 1),
    ("range beyond 64 bits", "len(range(10**18 * 9, -10**18 * 9, -1)) + len(range(2**62 * 2 - 1 + 2**62))", 1),
    ("comprehension", "[i for i in range(10**10)]", 1),
    ("nested comprehension", "[[j for j in range(10**4)] for i in range(10**4)]", 1),
    ("dict comprehension", "{i: [0] * 1000 for i in range(10**10)}", 1),
    ("generator", "sum(1 for i in range(10**10))", 1),
    ("product of ranges", "[0 for a in range(10**4) for b in range(10**4) for c in range(10**4)]", 1),
    ("star arguments", "max(*[1] * 10**10)", 1),
    ("star arguments again", "def f(*a):\n    f(*a, *a)\nf(1)", 2),
    ("keyword bomb", "def f(**k):\n    return k\nf(**{'a%d' % i: i for i in range(10**7)})", 3),
    ("zip", "list(zip(range(10**10), range(10**10)))", 1),
    ("enumerate", "list(enumerate(range(10**10)))", 1),
    ("map", "list(map(float, range(10**10)))", 1),
    ("choices", "import random\nrandom.choices([1], k=10**10)", 2),
    ("sample", "import random\nrandom.sample(range(10**10), 10**9)", 2),
    ("random bits", "import random\nrandom.getrandbits(10**9)", 2),
    ("segments", "import bpy\nbpy.ops.mesh.primitive_uv_sphere_add(segments=10**6, ring_count=10**6)", 2),
    ("subdivisions", "import bpy\nbpy.ops.mesh.primitive_ico_sphere_add(subdivisions=30)", 2),
    ("vertices", "import bpy\nbpy.data.meshes.new('a').from_pydata([(0, 0, 0)] * 10**7, [], [])", 2),
    ("a name without end", "import bpy\nbpy.data.objects.new('a' * 10**9, None)", 2),
    # what is compared, copied or counted again and again
    ("lists in an enumeration", "from enum import Enum\n" + _NESTED + "class E(Enum):\n    x = a\nE(b)", 9),
    ("lists in a generator", _NESTED + "b in (q for q in [a])", 6),
    ("lists in a named tuple", "from collections import namedtuple\n" + _NESTED + "b in namedtuple('P', 'x')(a)", 7),
    ("wide enumeration", "from enum import Enum\nclass E(Enum):\n" + _MANY_NAMES + "while True:\n    len(E)", 2),
    ("hasattr runs no property", _SLOW + "hasattr(A(), 'x')\nA().x", 4),
    ("empty lists in a row", "import itertools\na = [()] * 240000\nwhile True:\n"
     "    itertools.chain.from_iterable(a)", 4),
    ("kinds", "while True:\n    isinstance('a', (int,) * 200000)", 2),
    ("normals", _MESH + "bmesh.ops.create_grid(bm, x_segments=60, y_segments=60)\nf = bm.faces.new(bm.verts)\n"
     "while True:\n    f.normal", 6),
    ("a list in a modifier", _CUBE + "m = bpy.context.object.modifiers.new('a', 'ARRAY')\n"
     "m.use_merge_vertices = [0] * 240000", 4),
    ("first elements that go", "a = [0] * 250000\nwhile True:\n    del a[0]", 3),
    ("first elements that pop", "a = [0] * 250000\nwhile True:\n    a.pop(0)", 3),
    ("directions", "from mathutils import Vector\nwhile 1:\n    Vector((1, 2, 3)).to_track_quat('X', 'Z')", 3),
    ("products of vectors", "from mathutils import Vector\nv = Vector((1, 2, 3))\nwhile 1:\n    v = v.cross(v)", 4),
    ("inverses", "from mathutils import Matrix\nm = Matrix()\nwhile True:\n    m = m.inverted()", 4),
    ("angles of matrices", "from mathutils import Matrix\nwhile True:\n    Matrix.Rotation(1, 3, 'X').to_euler()", 3),
    ("collections of one object", _CUBE + "while True:\n"
     "    bpy.data.collections.new('a').objects.link(bpy.context.object)", 4),
    ("turns of an object", _CUBE + "while True:\n    bpy.ops.transform.rotate(value=1)", 4),
    ("places in the world", _CUBE + "o = bpy.context.object\nwhile True:\n    o.matrix_world = o.matrix_world", 5),
    ("extents of a sphere", "import bpy\nbpy.ops.mesh.primitive_uv_sphere_add(segments=500, ring_count=290)\n"
     "while 1:\n    bpy.context.object.dimensions", 4),
    ("generators of numbers", "import random\nwhile True:\n    random.Random(1)", 3),
    ("stars of modules", "while True:\n    from math import *", 2),
    ("a chain of comparisons", "x = 1\nwhile 1" + " < 2 > 1" * 6000 + ":\n    pass", 2),
    ("a chain of operators", "x = 1\nwhile " + "x or " * 12000 + "x:\n    pass", 2),
    ("many names of a class", "from enum import Enum\nclass E(Enum):\n" + _MANY_NAMES + "E(1)", 6003),
    ("many lines under a loop", "while True:\n" + "    x = 1\n" * 8000, 1994),
    # what is compared, raised and turned into text
    ("getattr of a dunder", "import bpy\ngetattr(bpy, '__class__')", 2),
    ("getattr private of text", "getattr('', '__class__').__mro__", 1),
    ("getattr in a format", "getattr('{0.__class__}', 'format')(1)", 1),
    ("getattr of a property without end", _SLOW + "getattr(A(), 'x', 1)", 4),
    ("duplicate_move", _CUBE + "o = bpy.context.object\no.name='Car'\nwhile True:\n"
     "    bpy.ops.object.duplicate_move(TRANSFORM_OT_translate={'value': (1, 0, 0)})", 6),
    ("LocRotScale", "from mathutils import Matrix\nwhile True:\n"
     "    Matrix.LocRotScale((1, 2, 3), (1, 2, 3), (1, 2, 3))", 3),
    ("edges of bmesh", _MESH + "bmesh.ops.create_grid(bm, x_segments=80, y_segments=80)\nwhile True:\n"
     "    bm.edges[0]", 5),
    ("edges of one face", _MESH + "f = bm.faces.new([bm.verts.new((i, 0, 0)) for i in range(4000)])\nwhile True:\n"
     "    for e in bm.edges:\n        e.calc_length()", 6),
    ("__str__ of itself", "class A:\n    def __str__(self):\n        return f'{self}'\nstr(A())", 3),
    ("__str__ that is long", "class A:\n    def __str__(self):\n        return 'a' * 200000\na = A()\nwhile True:\n"
     "    f'{a}{a}'", 6),
    ("__str__ doubles", "class A:\n    def __init__(self, x):\n        self.x = x\n    def __str__(self):\n"
     "        return f'{self.x}{self.x}'\na = 1\nfor i in range(60):\n    a = A(a)\nstr(a)", 5),
    ("dataclasses of dataclasses", _CLASS + "    x: object\n    y: object = 0\na = b = 1\nfor i in range(60):\n"
     "    a = A(a, a)\n    b = A(b, b)\na == b", 10),
    ("dataclasses as keys", _CLASS + "    x: object\n    y: object = 0\na = b = 1\nfor i in range(60):\n"
     "    a = A(a, a)\n    b = A(b, b)\nd = {a: 1}\nd[b]", 11),
    ("dataclasses in tuples in order", _CLASS + "    x: object\n    y: object = 0\na = []\nb = []\n"
     "for i in range(60):\n    a = [a, a]\n    b = [b, b]\nsorted([(A(a), 1), (A(b), 2)])", 11),
    (
        "wide dataclass as a key",
        "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass A:\n"
        + "".join(f"    a{k}: int = 0\n" for k in range(150))
        + "d = {A(): 1}\na = A()\nwhile True:\n    d[a]",
        157,
    ),
    ("keys of dataclasses", _CLASS + "    x: object\n    y: object = 0\nd = {}\ni = 0\nwhile True:\n    d[A(i)] = 1\n"
     "    i += 1", 9),
    ("raise with a long text", "x = 'a\\n' * 100000\nraise ValueError(x)", 2),
    ("raise again for ever", "def f():\n    try:\n        raise KeyError\n    except KeyError:\n        raise\n"
     "while True:\n    try:\n        f()\n    except KeyError:\n        pass", 2),
    ("zip of many", "a = iter([1])\nwhile True:\n    zip(*[a] * 1000)", 3),
    ("ids of what arrays make", _CUBE + "o = bpy.context.object\no.name='Car'\no['id'] = 'a' * 100000\n"
     "o.modifiers.new('a', 'ARRAY').count = 1000", 6),
    ("mesh of polygons", "import bpy\nm = bpy.data.meshes.new('a')\nwhile True:\n"
     "    m.from_pydata([(0, 0, 0)] * 3, [], [(0, 1, 2), (0, 1, 2, 0)] * 4000)", 4),
    ("cone tips", "import bpy\nwhile True:\n    bpy.ops.mesh.primitive_cone_add(vertices=500)\n"
     "    bpy.context.object.dimensions", 4),
    ("sets that grow", "s = set()\nwhile True:\n    s.add(len(s))", 3),
    ("sets of sets", "s = set(range(60000))\nwhile True:\n    s | s", 3),
    ("sets of many", "s = set()\nwhile True:\n    s.union(*[[]] * 9000)", 3),
    ("sets without", "s = set(range(60000))\nwhile True:\n    s.isdisjoint([])", 3),
    ("functions that are made", "while True:\n    def g(a, b=1, *c, d=2, **e): pass", 2),
    ("classes that are made", "while True:\n    class B: pass", 1),
    ("exit with lists of lists", "import sys\na=[1]\nfor i in range(60):\n    a=[a,a]\nsys.exit(a)", 5),
    ("children get many", _CHILDREN + "while True:\n    c.children.get('zz')", 6),
    ("children unlink", "import bpy\nc=bpy.context.scene.collection\nd=bpy.data.collections.new('a')\n"
     "for i in range(9000):\n    c.children.link(d)\ne=bpy.data.collections.new('e')\n"
     "c.children.link(e)\nwhile True:\n    c.children.unlink(e)\n    c.children.link(e)", 5),
    ("objects in collections", "import bpy\nm=bpy.data.meshes.new('m')\nfor i in range(2000):\n"
     "    bpy.context.collection.objects.link(bpy.data.objects.new('a',m))\n"
     "c=bpy.context.collection.objects\nwhile True:\n    'zz' in c", 7),
    ("mesh class property", _CUBE + "bpy.context.object.data['class']='a'*1900000", 2),
    ("text of two million compare", "s='a'*1900000+'b'\nt='a'*1900000+'c'\nwhile True:\n    s==t", 4),
    ("text of two million braces", "s='{}'*900000\nwhile True:\n    s.format(1)", 3),
    ("set with a range", "s = {1}\ns |= range(10**12)", 2),
    ("range with a set", "range(10**12) & {1}", 1),
    ("sums of weights", "import random\nrandom.choices([1] * 2000, weights=['a' * 100000] * 2000)", 2),
    ("sorted long texts", "a='a'*1900000+'b'\nb='a'*1900000+'c'\nsorted([a,b]*100000)", 3),
    ("sets of long texts", "a={'a'*1900000+str(i) for i in range(3)}\nb={'a'*1900000+str(i) for i in range(3)}\n"
     "while True:\n    a==b", 1),
    ("dict lookup long", "s='a'*1900000\nd={s+'b':1}\nt=s+'b'\nwhile True:\n    d[t]", 5),
    ("endswith long", "s='a'*1900000\nt='a'*1900000\nf=s.endswith\nwhile True:\n    f(t)", 5),
    ("method kept", "s='a'*1900000\nf=s.upper\nwhile True:\n    f()", 4),
    ("count kept", "s='a'*1900000\nf=s.count\nwhile True:\n    f('b')", 4),
    ("object in by name", _CUBE + "s='a'*1900000\nt='a'*1900000\nbpy.context.object.name=s\nwhile True:\n"
     "    t in bpy.data.objects", 7),
    ("get by long name", _CUBE + "s='a'*1900000\nt='a'*1900000\nbpy.context.object.name=s\nf=bpy.data.objects.get\n"
     "while True:\n    f(t)", 8),
    ("properties long keys", _CUBE + "o=bpy.context.object\ns='a'*1900000\no[s]=1\nt='a'*1900000\nwhile True:\n"
     "    t in o", 8),
    (
        "comparison of paths",
        "from pathlib import Path\np=Path('a/'*120000)\nq=Path('a/'*120000)\nwhile p" + " == q == p" * 9 + ": pass",
        2,
    ),
    ("enumerate of enumerate", "g=(x for x in [1])\nfor _ in range(200):\n    g=enumerate(g)\nnext(g)", 4),
    ("kept zips of a generator", "g=(x for x in [1])\nx=[]\nwhile True:\n    x.append(zip(*[g]*1000))", 4),
    ("all of a count", "import itertools\nall(itertools.count(1))", 2),
    ("map of method", "s='a'*1900000\nx=['b']*240000\nlist(map(s.find, x))", 3),
    # numbers that are none
    ("infinite place", "import bpy\nbpy.ops.mesh.primitive_cube_add(location=(float('inf'), 0, 0))", 2),
    ("place that is no number", "import bpy\nbpy.ops.mesh.primitive_cube_add(location=(float('nan'), 0, 0))", 2),
    ("1e308", "import bpy\nbpy.ops.mesh.primitive_cube_add(size=1e308 * 10)", 2),
    ("text as a size", "import bpy\nbpy.ops.mesh.primitive_cube_add(size='2')", 2),
    ("division by zero", "x = 1\ny = x / 0", 2),
    ("complex number", "x = (-8) ** 0.5", 1),
    ("overflow", "import math\nmath.exp(10**6)", 2),
    # text that breaks a parser
    ("null byte", "x = 1\ny = '\0'", 2),
    ("no Python", "x = 1\ny = = 2", 2),
    ("parentheses", "x = 1\n" + "(" * 5000 + ")" * 5000, 2),
    ("brackets", "x = " + "[" * 150 + "]" * 150, 1),
    ("braces", "x = 1\ny = " + "{1:" * 90 + "1" + "}" * 90 + "[0]" * 200, 2),
    ("signs", "x = 1\ny = " + "-" * 50000 + "1", 2),
    ("attributes", "import bpy\nbpy" + ".a" * 20000, 2),
    ("sum without end", "x = 1\ny = 1" + "+1" * 20000, 2),
    ("indentation", "".join(" " * k + "if 1:\n" for k in range(150)) + " " * 150 + "pass", 101),
    ("elif chain", "if 0:\n    pass\n" + "elif 0:\n    pass\n" * 2000, 299),
    ("unknown conversion of an f-string", "x = 1\ny = f'{x!z}'", 2),
    ("too many tokens", "x = [" + "1," * 200000 + "]", 1),
    ("too many lines", "x = 1\n" * 100000, 20834),
    ("long text in three quotes", 'x = 1\ny = """' + "a" * 3_900_000 + '"""', 2),
    ("quotes in three quotes", "x = 1\ny = '''" + '"a' * 1_900_000 + "'''", 2),
    ("empty lines", "\n" * 3_900_000, 125_001),
    ("long name", "x = 1\n" + "a" * 3_900_000, 2),
    ("long number", "x = 1\ny = 1." + "1" * 3_900_000, 2),
    ("too long", "# " + "a" * 5_000_000, 1),
    ("lone surrogate", "x = 1\nx = '\ud800'", 2),
    ("lone surrogate in an escape", "x = 1\nx = '\\ud800'", 2),
    ("nothing", "", 1),
    ("nothing but a comment", "# a scene", 1),
]
# fmt: on


def says_where(said: str, script: str, line: int) -> bool:
    """Whether a refusal names the line or, where the script takes too long, any line of it."""
    named = re.match(r"line (\d+): ", said)
    return bool(named) and (int(named[1]) == line or ("; `limits`" in said and int(named[1]) <= 1 + script.count("\n")))
